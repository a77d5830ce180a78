// Kinematics of serial arms: forward kinematics, Jacobians, inverse kinematics, a servo. C++17, no heap, no exceptions.
#pragma once

#include "answer.hpp"
#include "batch.hpp"
#include "conversion.hpp"
#include "race.hpp"
#include "servo.hpp"
