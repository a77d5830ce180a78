// Kinematics of serial arms: forward kinematics, Jacobians, inverse kinematics, a servo, motors. C++17, no heap, no exceptions.
#pragma once

#include "actuators.hpp"
#include "answer.hpp"
#include "batch.hpp"
#include "conversion.hpp"
#include "race.hpp"
#include "servo.hpp"
