// Stand-in: a plugin is a class of its base, and no abstract one.
#pragma once
#include <type_traits>
#define PLUGINLIB_EXPORT_CLASS(Class, Base) \
    static_assert(std::is_base_of_v<Base, Class> && !std::is_abstract_v<Class> && std::is_default_constructible_v<Class>);
