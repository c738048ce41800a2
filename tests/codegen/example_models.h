// SPDX-License-Identifier: MIT
// Small valid models with deterministic pseudo-random weights, one for each feature of a model. They estimate nothing;
// tests write, fold, export and step them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codegen/model/model.h"

namespace nlo::codegen {

/// The paper's network: one output, three real eigenvalues, T* 3-50x4-2, tanh, no feed-through.
Model paper_model();

/// A model like that of a real rig: an angle and another output, complex pairs, real eigenvalues, a clock, a linear
/// path. T* reads the other output directly and the angle only as z - y. Starts at the steady state of the first
/// output.
Model rig_model();

/// One output, one state, two real eigenvalues, T* 2-4-1: small enough to read when exported.
Model tiny_model();

/// Returns `tiny_model` with a wider T* and this activation ("relu", "silu", "tanh").
Model activation_model(const std::string& activation);

/// `tiny_model` with a monitor; `rig_model`, with an angle; `computed_model`, with computed outputs.
Model watched_model();
Model watched_rig_model();
Model watched_computed_model();

/// T* is one layer: a linear observer.
Model linear_model();

/// Returns `tiny_model` with this hold ("zero_order", "first_order", "rk4").
Model hold_model(const std::string& hold);

/// Structure (15): a pendulum with a known linear part, g_hat 2-8-2.
Model luenberger_model();

/// Structure (11): two outputs, three latent states; F = a stable linear path plus a small 5-12-3, G 3-8-2.
Model general_model();
/// Five gated units; T* reads [z; y].
Model gated_model();
Model contracting_gated_model();  ///< with a proof of contraction

/// Structure (24)-(25): a complex pair and a real eigenvalue, one output, two inputs, g(x) affine; T 2-12-3 and T*
/// 3-12-2, each with a linear path.
Model driven_model();

/// `rig_model` without its angle, with two known inputs that have their own modes and that T* also reads: commands, or
/// (`commanded_ramp`) measured with y.
Model commanded_model();

/// A DC motor whose encoder counts turns without end. It is linear, so T and T* have closed forms, and T* reads the
/// encoder only as z - y. States: speed, current, load; input: voltage. Not in example_models(), because its T*
/// amplifies rounding.
Model encoder_model();
Model commanded_ramp_model();

/// `commanded_model` and `rig_model` whose T* also reads the products of its features with their clock.
Model clocked_model();
Model clocked_rig_model();
Model fallback_model();

/// Applies the fallback of a folded network to its output `out`; in: [in; products].
void fall_back(const Fallback& fallback, const Eigen::VectorXd& in, Eigen::VectorXd& out);

/// `commanded_model` with a second output that may be missing; and `rig_model` without inputs, whose load may be
/// missing.
Model failing_model();
Model failing_rig_model();
/// `rig_model` whose second output is measured in every fifth sample; the same with its angle in every third.
Model two_rates_model();
Model slow_angle_model();
/// `two_rates_model` with a monitor; `failing_rig_model` and `failing_model` with a slow output that may be missing.
Model watched_two_rates_model();
Model failing_two_rates_model();
Model watched_failing_two_rates_model();
/// `failing_model` with two more outputs, computed from outputs and inputs; `gated_model` with the product of its two
/// outputs.
Model computed_model();
Model computed_gated_model();
Model saturating_model();      // saturates z
Model saturating_rig_model();  // saturates z - S y for an angle y

/// The other structures with a known input: (15) with B u, (11) with F(z, y, u).
Model commanded_luenberger_model();
Model commanded_general_model();
Model commanded_gated_model();

/// Gated units with a second output that may be missing.
Model failing_gated_model();

/// Two vectors and the rate of rotation that carries them; a pair and a real mode; the estimate is a unit vector.
Model carried_model();

/// A driven Van der Pol oscillator as the prior; two outputs, one input; four units, T* 9-8-2.
Model prior_model();
/// A model whose equations use each function and a division.
Model prior_functions_model();
/// prior_model() and prior_functions_model() without units: extended Kalman filters.
Model filter_model();
Model filter_functions_model();
/// A filter for a double pendulum whose second joint no sensor measures. The torques are inputs. Its numbers come from
/// a rig.
Model hidden_joint_model();
/// prior_functions_model() with x2 as the only estimated state.
Model prior_unestimated_model();

/// T* 3-256x3-2, written in memory layout. This model and the next are not in example_models(), because they are slow.
Model large_model();

/// T* 3-18-300-60-2: large, with layers of both forms and all parts of the panel layout: tiles of two sizes, eight,
/// rest.
Model mixed_model();

/// Returns `model` as "NAME_error", with an error head on T*: sigma between .05 and 2.
Model with_error(Model model, std::uint64_t seed);

/// Returns a model with an error head for each structure with a T*; some have an angle, saturation or a linear path.
std::vector<Model> error_models();

/// Returns the last models of example_models(): one of each structure except the plain KKL.
std::vector<Model> structure_models();

/// Returns the models of all functions above. Their names are unique.
std::vector<Model> example_models();

}  // namespace nlo::codegen
