// Kinematics of serial arms: forward kinematics, Jacobians, inverse kinematics, a servo, motors. C++17, no heap, no
// exceptions. A program includes this header alone. Its rooms, each built on those before it:
//
//   numeric/      packs of numbers (lanes), elementary functions, small linear systems
//   kinematics/   chains, frames, forward kinematics and Jacobians, motors, motion limits
//   ik/           from a target to a configuration, or to the nearest one and the reason
//   closed_form/  from a target to every configuration that meets it
//   planning/     the velocity along a path, and what a smoothed one needs
//   servo/        one step from a command to joint rates
#pragma once

#include "closed_form/all_solutions.hpp"
#include "ik/answer.hpp"
#include "ik/batch.hpp"
#include "ik/race.hpp"
#include "ik/reachable.hpp"
#include "ik/reaches.hpp"
#include "kinematics/actuators.hpp"
#include "kinematics/conversion.hpp"
#include "planning/smoothed_law.hpp"
#include "servo/servo.hpp"
