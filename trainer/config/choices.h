// SPDX-License-Identifier: MIT
// Closed sets of choices in an experiment: each is an enumeration with its names. Open sets (plants, structures,
// losses, optimisers, schedules, activations) are names in the tables of their folders.
#pragma once

#include "codegen/model/hold.h"
#include "trainer/base/names.h"

namespace nlo::trainer {

/// Distribution of initial states: uniform over the box; normal, with the centre of the box as mean and its half widths
/// as 1 sigma; circle: c + a cos phi + b sin phi with uniform phi; list: the listed states, each once per round in
/// random order.
enum class InitialDistribution { kUniform, kGaussian, kCircle, kList };
template <>
inline constexpr NameTable<InitialDistribution, 4> kNames<InitialDistribution>{
    {{InitialDistribution::kUniform, "uniform"},
     {InitialDistribution::kGaussian, "gaussian"},
     {InitialDistribution::kCircle, "circle"},
     {InitialDistribution::kList, "list"}}};

/// Course of a drawn input over a trajectory, see plants/drawn_inputs.h.
enum class InputSignal { kZero, kConstant, kSteps, kPrbs, kSine, kSquare, kMultisine, kChirp, kNoise, kLog };
template <>
inline constexpr NameTable<InputSignal, 10> kNames<InputSignal>{{{InputSignal::kZero, "zero"},
                                                                 {InputSignal::kConstant, "constant"},
                                                                 {InputSignal::kSteps, "steps"},
                                                                 {InputSignal::kPrbs, "prbs"},
                                                                 {InputSignal::kSine, "sine"},
                                                                 {InputSignal::kSquare, "square"},
                                                                 {InputSignal::kMultisine, "multisine"},
                                                                 {InputSignal::kChirp, "chirp"},
                                                                 {InputSignal::kNoise, "noise"},
                                                                 {InputSignal::kLog, "log"}}};

/// Encoding of an angle: one channel without jumps, or two channels NAME_sin and NAME_cos.
enum class Encoding { kUnwrap, kSincos };
template <>
inline constexpr NameTable<Encoding, 2> kNames<Encoding>{
    {{Encoding::kUnwrap, "unwrap"}, {Encoding::kSincos, "sincos"}}};

/// Role of a column. The truth of a row counts if its mask is not 0.
enum class ColumnRole { kTime, kOutput, kState, kInput, kMask, kIgnored };
template <>
inline constexpr NameTable<ColumnRole, 6> kNames<ColumnRole>{{{ColumnRole::kTime, "time"},
                                                              {ColumnRole::kOutput, "output"},
                                                              {ColumnRole::kState, "state"},
                                                              {ColumnRole::kInput, "input"},
                                                              {ColumnRole::kMask, "mask"},
                                                              {ColumnRole::kIgnored, "ignored"}}};

template <>
inline constexpr auto kNames<Hold> = codegen::kHoldNames;

/// F of D z + F y: ones, or -lambda, so that z settles at y.
enum class Injection { kOnes, kUnitGain };
template <>
inline constexpr NameTable<Injection, 2> kNames<Injection>{
    {{Injection::kOnes, "ones"}, {Injection::kUnitGain, "unit_gain"}}};

/// Start of z: zero, or the steady state for the first output.
enum class LatentStart { kZero, kSteady };
template <>
inline constexpr NameTable<LatentStart, 2> kNames<LatentStart>{
    {{LatentStart::kZero, "zero"}, {LatentStart::kSteady, "steady"}}};

/// Features of T*: z; z and y; z - y and y.
enum class FeatureSet { kLatent, kLatentAndOutput, kLatentMinusOutput };
template <>
inline constexpr NameTable<FeatureSet, 3> kNames<FeatureSet>{{{FeatureSet::kLatent, "latent"},
                                                              {FeatureSet::kLatentAndOutput, "latent_and_output"},
                                                              {FeatureSet::kLatentMinusOutput, "latent_minus_output"}}};

/// Features that T* also reads multiplied by each clock.
enum class ClockProductSet { kNone, kLatent, kAll };
template <>
inline constexpr NameTable<ClockProductSet, 3> kNames<ClockProductSet>{
    {{ClockProductSet::kNone, "none"}, {ClockProductSet::kLatent, "latent"}, {ClockProductSet::kAll, "all"}}};

/// Selects the readout of a state in the model (shipped_model.h). kSelected: network, linear row or blend, by the
/// smallest transient and settled errors. kSettled: by the smallest settled error alone. kNetwork: always the network.
enum class ReadoutChoice { kSelected, kSettled, kNetwork };
template <>
inline constexpr NameTable<ReadoutChoice, 3> kNames<ReadoutChoice>{{{ReadoutChoice::kSelected, "selected"},
                                                                    {ReadoutChoice::kSettled, "settled"},
                                                                    {ReadoutChoice::kNetwork, "network"}}};

/// Returns true if training selects the readouts.
constexpr bool is_chosen(ReadoutChoice readout) {
  return readout != ReadoutChoice::kNetwork;
}

/// Reduction of the running cost over time. The integral is the mean times the horizon.
enum class Reduction { kMean, kIntegral, kLogarithm };
template <>
inline constexpr NameTable<Reduction, 3> kNames<Reduction>{
    {{Reduction::kMean, "mean"}, {Reduction::kIntegral, "integral"}, {Reduction::kLogarithm, "logarithm"}}};

/// Points at which the plant's equations (5) must hold: the samples, or points of a box.
enum class EquationPoints { kData, kBox };
template <>
inline constexpr NameTable<EquationPoints, 2> kNames<EquationPoints>{
    {{EquationPoints::kData, "data"}, {EquationPoints::kBox, "box"}}};

/// Squared errors in the units of x and z, or divided by their variance.
enum class ErrorScale { kPhysical, kNormalised };
template <>
inline constexpr NameTable<ErrorScale, 2> kNames<ErrorScale>{
    {{ErrorScale::kPhysical, "physical"}, {ErrorScale::kNormalised, "normalised"}}};

/// Samples of one training step: drawn at random, or every sample of every trajectory.
enum class TrainingMode { kRandomSamples, kFullBatch };
template <>
inline constexpr NameTable<TrainingMode, 2> kNames<TrainingMode>{
    {{TrainingMode::kRandomSamples, "random_samples"}, {TrainingMode::kFullBatch, "full_batch"}}};

/// Gradient of the latent system. Automatic: the exact filter if the latent system is linear, else backpropagation. The
/// others work for every structure through RK4: backpropagation, or the adjoint (Proposition 1).
enum class LatentGradient { kAutomatic, kBackprop, kAdjoint };
template <>
inline constexpr NameTable<LatentGradient, 3> kNames<LatentGradient>{{{LatentGradient::kAutomatic, "automatic"},
                                                                      {LatentGradient::kBackprop, "backprop"},
                                                                      {LatentGradient::kAdjoint, "adjoint"}}};

/// Training uses the start of the filter, or excludes it in one of two ways (data/transient.h).
enum class Transient { kKeep, kDrop, kBackward };
template <>
inline constexpr NameTable<Transient, 3> kNames<Transient>{
    {{Transient::kKeep, "keep"}, {Transient::kDrop, "drop"}, {Transient::kBackward, "backward"}}};

}  // namespace nlo::trainer
