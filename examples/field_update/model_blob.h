// SPDX-License-Identifier: MIT
// Stores a new model for a unit in the field: the bytes of the model behind a header with layout, version and CRC (a
// blob). The firmware stays unchanged. It accepts a blob only if layout, version and CRC fit, and if the model gives
// the same estimate after a recorded flight as when the blob was written.
//
//   build machine   compile the new exported header for the same target, call write_blob(), flash the bytes
//   firmware        const auto [model, status] = checked_model<van_der_pol::Model>(flash, size, least_version);
//                   exchange the observer by exchanged() below; if `model` is null, keep the compiled model
//
// Two exports have the same layout if they have the same structure, sizes and scalar type, so a new training of the
// same experiment fits. Copy this header and change its requirements.
#pragma once

#include <nlo/vector.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace nlo::examples {

enum class BlobStatus : std::uint8_t {
  kOk,
  kMisaligned,    ///< the first byte is not aligned for a model
  kShort,         ///< fewer bytes than a blob has
  kNotABlob,      ///< another magic number, such as an erased flash
  kOtherLayout,   ///< another structure, other sizes or another target
  kOlder,         ///< a version below the oldest accepted one
  kDamaged,       ///< the CRC does not match the bytes
  kOtherAnswers,  ///< the recorded flight ends with another estimate
};

inline constexpr int kFlightSamples = 8;

template <class Model>
struct alignas(Model) alignas(8) ModelBlob {
  using Scalar = typename Model::Scalar;
  std::uint32_t magic, layout, version, crc;               ///< crc: of the version and of all following bytes
  Scalar flight[kFlightSamples][Model::kNy + Model::kNu];  ///< outputs, then inputs
  Scalar answer[Model::kNx];                               ///< x_hat after the last sample of the flight
  alignas(Model) unsigned char model[sizeof(Model)];
};

inline constexpr std::uint32_t kBlobMagic = 0x314F4C4EU;  // "NLO1"

/// Returns the CRC-32 (IEEE 802.3) of `size` bytes, continuing from `crc`.
inline std::uint32_t crc32(const unsigned char* bytes, std::size_t size, std::uint32_t crc = 0) {
  crc = ~crc;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

/// Returns a number for the layout of a model's bytes, from its type with all sizes and from the target.
template <class Model>
std::uint32_t layout_of() {
#if defined(__ARM_ARCH)
  constexpr std::uint32_t kTarget = 0x100U + __ARM_ARCH;
#elif defined(__riscv)
  constexpr std::uint32_t kTarget = 0x200U;
#else
  constexpr std::uint32_t kTarget = 0U;
#endif
  const std::uint32_t facts[] = {kTarget, sizeof(Model), alignof(Model), sizeof(ModelBlob<Model>),
                                 1U};  // 1: byte order
  const char* type = __PRETTY_FUNCTION__;
  const std::uint32_t of_type = crc32(reinterpret_cast<const unsigned char*>(type), std::strlen(type));
  return crc32(reinterpret_cast<const unsigned char*>(facts), sizeof facts, of_type);
}

template <class Model>
std::uint32_t crc_of(const ModelBlob<Model>& blob) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(&blob);
  constexpr std::size_t kBegin = offsetof(ModelBlob<Model>, flight);
  const std::uint32_t version = crc32(bytes + offsetof(ModelBlob<Model>, version), sizeof blob.version);
  return crc32(bytes + kBegin, sizeof blob - kBegin, version);
}

/// Returns x_hat after the flight, computed by Observer<Model> from a reset.
template <class Observer>
typename Observer::Estimate answer_of(
    const typename Observer::Model& model,
    const typename Observer::Model::Scalar (&flight)[kFlightSamples][Observer::Model::kNy + Observer::Model::kNu]) {
  Observer observer(model);
  for (const auto& readings : flight) {
    Vector<typename Observer::Model::Scalar, Observer::Model::kNy> y{};
    for (int j = 0; j < Observer::Model::kNy; ++j) y[j] = readings[j];
    if constexpr (Observer::Model::kNu > 0) {
      Vector<typename Observer::Model::Scalar, Observer::Model::kNu> u{};
      for (int j = 0; j < Observer::Model::kNu; ++j) u[j] = readings[Observer::Model::kNy + j];
      (void)observer.step(y, u);
    } else {
      (void)observer.step(y);
    }
  }
  return observer.estimate();
}

/// Writes `model` with a flight over the range of its outputs. `blob` is zeroed first,
/// so that equal models have equal bytes.
template <class Observer>
void write_blob(const typename Observer::Model& model, std::uint32_t version,
                ModelBlob<typename Observer::Model>& blob) {
  using Model = typename Observer::Model;
  static_assert(std::is_trivially_copyable_v<Model> && std::is_standard_layout_v<ModelBlob<Model>>);
  std::memset(&blob, 0, sizeof blob);
  blob.magic = kBlobMagic;
  blob.layout = layout_of<Model>();
  blob.version = version;
  for (int k = 0; k < kFlightSamples; ++k) {
    const auto share = static_cast<typename Model::Scalar>(0.3 + 0.05 * k);  // position within the range, 0 to 1
    for (int j = 0; j < Model::kNy; ++j)
      blob.flight[k][j] = model.outputs.min[j] + share * (model.outputs.max[j] - model.outputs.min[j]);
    for (int j = 0; j < Model::kNu; ++j) blob.flight[k][Model::kNy + j] = share;
  }
  const auto answer = answer_of<Observer>(model, blob.flight);
  for (int i = 0; i < Model::kNx; ++i) blob.answer[i] = answer[i];
  std::memcpy(&blob.model, &model, sizeof model);
  blob.crc = crc_of(blob);
}

template <class Model>
struct CheckedModel {
  const Model* model = nullptr;  ///< points into the checked bytes; nullptr unless kOk
  BlobStatus status = BlobStatus::kShort;
};

/// Checks a blob of `size` bytes at `data` and returns its model. The bytes must stay there while an observer uses it.
///   least_version  older versions are refused
template <class Observer>
CheckedModel<typename Observer::Model> checked_model(const void* data, std::size_t size, std::uint32_t least_version) {
  using Model = typename Observer::Model;
  using Blob = ModelBlob<Model>;
  if (reinterpret_cast<std::uintptr_t>(data) % alignof(Blob) != 0) return {nullptr, BlobStatus::kMisaligned};
  if (size < sizeof(Blob)) return {nullptr, BlobStatus::kShort};
  const Blob& blob = *static_cast<const Blob*>(data);
  if (blob.magic != kBlobMagic) return {nullptr, BlobStatus::kNotABlob};
  if (blob.layout != layout_of<Model>()) return {nullptr, BlobStatus::kOtherLayout};
  if (blob.crc != crc_of(blob)) return {nullptr, BlobStatus::kDamaged};
  if (blob.version < least_version) return {nullptr, BlobStatus::kOlder};
  const auto* model = reinterpret_cast<const Model*>(&blob.model);
  const auto answer = answer_of<Observer>(*model, blob.flight);
  for (int i = 0; i < Model::kNx; ++i) {
    const auto difference = answer[i] - blob.answer[i];
    const auto size_of = blob.answer[i] < 0 ? -blob.answer[i] : blob.answer[i];
    // The blob may come from another arithmetic on the same target, with other roundings. NaN is refused, too.
    const auto limit = typename Model::Scalar(1e-4) * (size_of + typename Model::Scalar(1));
    if (!(difference < limit && -difference < limit)) return {nullptr, BlobStatus::kOtherAnswers};
  }
  return {model, BlobStatus::kOk};
}

/// Returns an observer of the new model in place of `running`. If only T* has changed, it continues with the same z,
/// without a transient. If the latent system has changed, it starts again.
template <class Observer>
Observer exchanged(const Observer& running, const typename Observer::Model& next) {
  Observer observer(next);
  if (std::memcmp(&running.model().latent, &next.latent, sizeof next.latent) == 0)
    (void)observer.restore(running.save());
  return observer;
}

}  // namespace nlo::examples
