// SPDX-License-Identifier: MIT
// A new model for a unit in the field: the bytes of a model behind a header that says which layout they have, which
// version they are, and their CRC. The firmware stays as it is; it takes a blob only when all of these fit and the
// model answers a recorded flight as it did when the blob was written.
//
//   build machine   compile the new exported header for the same target, call write_blob(), flash the bytes
//   firmware        const auto [model, status] = checked_model<van_der_pol::Model>(flash, size, least_version);
//                   take over with exchanged() below; without a model, go on with the one that was compiled in
//
// Two exports have the same layout when they have the same structure, sizes and scalar type, so a new training of the
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
  kMisaligned,    ///< the bytes do not start where a model may
  kShort,         ///< fewer bytes than a blob has
  kNotABlob,      ///< another magic number, such as an erased flash
  kOtherLayout,   ///< another structure, other sizes or another target
  kOlder,         ///< a version below the least that is accepted
  kDamaged,       ///< the CRC is not that of the bytes
  kOtherAnswers,  ///< the recorded flight ends elsewhere
};

inline constexpr int kFlightSamples = 8;

template <class Model>
struct alignas(Model) alignas(8) ModelBlob {
  using Scalar = typename Model::Scalar;
  std::uint32_t magic, layout, version, crc;               ///< crc of all that follows, and of the version
  Scalar flight[kFlightSamples][Model::kNy + Model::kNu];  ///< outputs, then inputs
  Scalar answer[Model::kNx];                               ///< x_hat after the last of them
  alignas(Model) unsigned char model[sizeof(Model)];
};

inline constexpr std::uint32_t kBlobMagic = 0x314F4C4EU;  // "NLO1"

/// CRC-32 (IEEE 802.3) of `size` bytes, continuing from `crc`.
inline std::uint32_t crc32(const unsigned char* bytes, std::size_t size, std::uint32_t crc = 0) {
  crc = ~crc;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

/// A number that differs where the bytes of a model mean something else: its type with all sizes, and the target.
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

/// x_hat after the flight, by Observer<Model>, from a reset.
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
    const auto share = static_cast<typename Model::Scalar>(0.3 + 0.05 * k);  // between the ends of the range
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
  const Model* model = nullptr;  ///< in the bytes that were checked; nullptr unless kOk
  BlobStatus status = BlobStatus::kShort;
};

/// The model in `size` bytes at `data`, which must stay there as long as an observer uses it.
///   least_version  a unit refuses older versions
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
    // Written by another arithmetic of the same target: some roundings. NaN is not below any limit.
    const auto limit = typename Model::Scalar(1e-4) * (size_of + typename Model::Scalar(1));
    if (!(difference < limit && -difference < limit)) return {nullptr, BlobStatus::kOtherAnswers};
  }
  return {model, BlobStatus::kOk};
}

/// An observer of the new model in place of `running`. z means the same to both where only T* has changed: then it goes
/// on without a transient. Where the latent system is another one, z says nothing, and the observer starts again.
template <class Observer>
Observer exchanged(const Observer& running, const typename Observer::Model& next) {
  Observer observer(next);
  if (std::memcmp(&running.model().latent, &next.latent, sizeof next.latent) == 0)
    (void)observer.restore(running.save());
  return observer;
}

}  // namespace nlo::examples
