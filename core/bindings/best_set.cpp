// A program for CMake: its exit code is the best instruction set of this machine.
#include "processor.hpp"

int main() { return bindings::best_set(); }
