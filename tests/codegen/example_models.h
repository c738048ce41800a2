// SPDX-License-Identifier: MIT
// Small valid models with deterministic pseudo-random weights, one for each thing a model can have. They estimate
// nothing; they are shapes to write, fold, export and step.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codegen/model/model.h"

namespace nlo::codegen {

/// The paper's network: one output, three real eigenvalues, T* 3-50x4-2, tanh, no feed-through.
Model paper_model();

/// A model as of a real rig: an angle and a plain output, complex pairs, real eigenvalues, a clock, a linear path, the
/// plain output fed through to T*, the angle only as z - y; starts at the steady state of the first output.
Model rig_model();

/// One output, one state, two real eigenvalues, T* 2-4-1: small enough to read when exported.
Model tiny_model();

/// `tiny_model` with a wider T* and this activation ("relu", "silu", "tanh").
Model activation_model(const std::string& activation);

/// `tiny_model` with a monitor; `rig_model`, whose angle turns; `computed_model`, whose outputs are not all measured.
Model watched_model();
Model watched_rig_model();
Model watched_computed_model();

/// T* is one layer: a linear observer.
Model linear_model();

/// `tiny_model` with this hold ("zero_order", "first_order", "rk4").
Model hold_model(const std::string& hold);

/// (15): a pendulum with its linear part known, g_hat 2-8-2.
Model luenberger_model();

/// (11): two outputs, three latent states; F = a stable linear path and a small 5-12-3 beside it, G 3-8-2.
Model general_model();
/// Five gated units; T* reads [z; y].
Model gated_model();
Model contracting_gated_model();  ///< with its proof

/// (24)-(25): a complex pair and a real eigenvalue, one output, two inputs, g(x) affine, T 2-12-3, T* 3-12-2 with a
/// linear path each.
Model driven_model();

/// `rig_model` without its angle, with two known inputs that have modes of their own and that T* reads too: commands,
/// or (`commanded_ramp`) measured with y.
Model commanded_model();

/// A DC motor whose encoder counts turns without end: linear, so T and T* are closed forms, and T* knows the encoder
/// only relatively. States: speed, current, load; input: voltage. Not among example_models(): its T* makes much of a
/// rounding.
Model encoder_model();
Model commanded_ramp_model();

/// `commanded_model` and `rig_model` whose T* also reads the products of its features with their clock.
Model clocked_model();
Model clocked_rig_model();
Model fallback_model();

/// Applies the fallback of a folded network to its output `out`; in: [in; products].
void fall_back(const Fallback& fallback, const Eigen::VectorXd& in, Eigen::VectorXd& out);

/// `commanded_model` with a second output that may be missing; and `rig_model`, which knows no input, whose load may.
Model failing_model();
Model failing_rig_model();
/// `rig_model` whose plain output is measured in each fifth sample; whose angle is, in each third.
Model two_rates_model();
Model slow_angle_model();
/// `two_rates_model` with a monitor; `failing_rig_model` and `failing_model`, whose output that may be missing is slow.
Model watched_two_rates_model();
Model failing_two_rates_model();
Model watched_failing_two_rates_model();
/// `failing_model` with two more outputs, computed of outputs and inputs; `gated_model` with the product of its two.
Model computed_model();
Model computed_gated_model();
Model saturating_model();      // saturates z
Model saturating_rig_model();  // saturates z - S y for an angle y

/// The other structures with a known input: (15) with B u, (11) with F(z, y, u).
Model commanded_luenberger_model();
Model commanded_general_model();
Model commanded_gated_model();

/// Gated units whose second output may be missing.
Model failing_gated_model();

/// Two vectors and the rate of rotation that carries them; a pair and a real mode; a unit vector is estimated.
Model carried_model();

/// A driven Van der Pol oscillator as the prior, two outputs, one input; four units, T* 9-8-2.
Model prior_model();
/// A model with equations that use every function and a division.
Model prior_functions_model();
/// The model before, of which x2 alone is estimated.
Model prior_unestimated_model();

/// T* 3-256x3-2, written as it lies in memory. This one and the next are not among example_models(): they are slow.
Model large_model();

/// T* 3-18-300-60-2, large, with layers of either form and what the panels' layout has: tiles of two sizes, eight,
/// rest.
Model mixed_model();

/// `model` as "NAME_error", with an error head on its T*: sigma between .05 and 2.
Model with_error(Model model, std::uint64_t seed);

/// A model of each structure that has a T*, with an error head; an angle, saturation, a linear path among them.
std::vector<Model> error_models();

/// The last of example_models(): a model of every structure but the plain KKL.
std::vector<Model> structure_models();

/// All of the above; names are distinct.
std::vector<Model> example_models();

}  // namespace nlo::codegen
