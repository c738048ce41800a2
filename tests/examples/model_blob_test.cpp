// SPDX-License-Identifier: MIT
// A model that arrives as bytes: it is accepted if it is complete, and refused for each kind of damage. Tests also what
// happens to z.
#include "examples/field_update/model_blob.h"

#include <gtest/gtest.h>
#include <nlo/kkl_observer.h>

#include <cmath>
#include <memory>

#include "tests/golden/driven.h"
#include "tests/golden/watched.h"

namespace nlo::examples {
namespace {

using Observer = watched::Observer;
using Blob = ModelBlob<watched::Model>;

/// The result of a new training: the same sizes, other weights of T*.
watched::Model retrained() {
  watched::Model model = watched::kModel;
  model.outputs.max[0] = 3.5F;
  model.domain.latent_max[0] = 4.5F;
  auto* bytes = reinterpret_cast<unsigned char*>(&model.inverse_map);
  float weight = 0.0F;
  std::memcpy(&weight, bytes, sizeof weight);
  weight *= 1.25F;
  std::memcpy(bytes, &weight, sizeof weight);
  return model;
}

float wave(int k) {
  return 0.5F * std::sin(0.05F * static_cast<float>(k));
}

TEST(ModelBlob, AnAcceptedModelGivesTheSameBitsAsTheCompiledOne) {
  const watched::Model model = retrained();
  auto blob = std::make_unique<Blob>();
  write_blob<Observer>(model, 7, *blob);
  const auto [loaded, status] = checked_model<Observer>(blob.get(), sizeof(Blob), 7);
  ASSERT_EQ(status, BlobStatus::kOk);
  Observer from_bytes(*loaded), compiled(model), old(watched::kModel);
  bool differs = false;
  for (int k = 0; k < 500; ++k) {
    EXPECT_EQ(from_bytes.step(wave(k)), compiled.step(wave(k)));
    (void)old.step(wave(k));
    ASSERT_EQ(from_bytes.estimate()[0], compiled.estimate()[0]) << k;
    differs = differs || from_bytes.estimate()[0] != old.estimate()[0];
  }
  EXPECT_TRUE(differs) << "control: the new weights differ";
}

TEST(ModelBlob, EveryFlippedBitIsRefused) {
  auto blob = std::make_unique<Blob>();
  write_blob<Observer>(watched::kModel, 7, *blob);
  auto* bytes = reinterpret_cast<unsigned char*>(blob.get());
  int flipped = 0;
  for (std::size_t i = 0; i < sizeof(Blob); ++i)
    for (int bit = 0; bit < 8; ++bit, ++flipped) {
      bytes[i] = static_cast<unsigned char>(bytes[i] ^ (1U << bit));
      const auto [model, status] = checked_model<Observer>(blob.get(), sizeof(Blob), 0);
      ASSERT_NE(status, BlobStatus::kOk) << "byte " << i << ", bit " << bit;
      ASSERT_EQ(model, nullptr);
      bytes[i] = static_cast<unsigned char>(bytes[i] ^ (1U << bit));
    }
  EXPECT_GT(flipped, 1000);
  EXPECT_EQ(checked_model<Observer>(blob.get(), sizeof(Blob), 0).status, BlobStatus::kOk)
      << "control: with all bits restored";
}

TEST(ModelBlob, RefusalsGiveTheirReason) {
  auto blob = std::make_unique<Blob>();
  const auto status = [&](std::size_t size = sizeof(Blob), std::uint32_t least = 7) {
    return checked_model<Observer>(blob.get(), size, least).status;
  };
  std::memset(blob.get(), 0xFF, sizeof(Blob));  // erased flash
  EXPECT_EQ(status(), BlobStatus::kNotABlob);
  write_blob<Observer>(watched::kModel, 7, *blob);
  EXPECT_EQ(status(), BlobStatus::kOk);
  EXPECT_EQ(status(sizeof(Blob) - 1), BlobStatus::kShort);
  EXPECT_EQ(status(sizeof(Blob), 8), BlobStatus::kOlder);
  EXPECT_EQ(checked_model<Observer>(reinterpret_cast<unsigned char*>(blob.get()) + 1, sizeof(Blob), 7).status,
            BlobStatus::kMisaligned);
  blob->answer[0] += 0.01F;
  EXPECT_EQ(status(), BlobStatus::kDamaged);
  blob->crc = crc_of(*blob);  // complete, but of another model
  EXPECT_EQ(status(), BlobStatus::kOtherAnswers);
  ModelBlob<driven::Model> other;
  write_blob<driven::Observer>(driven::kModel, 7, other);
  EXPECT_EQ(checked_model<driven::Observer>(&other, sizeof other, 7).status, BlobStatus::kOk) << "a model with inputs";
  ASSERT_GE(sizeof other, sizeof(Blob));
  EXPECT_EQ(checked_model<Observer>(&other, sizeof other, 7).status, BlobStatus::kOtherLayout);
}

TEST(ModelBlob, CrcEqualsThatOfTheStandard) {
  const unsigned char check[] = "123456789";
  EXPECT_EQ(crc32(check, 9), 0xCBF43926U);
  EXPECT_EQ(crc32(check + 4, 5, crc32(check, 4)), 0xCBF43926U) << "computed in two parts";
}

TEST(ModelBlob, ZContinuesIfOnlyTheMapChangedAndRestartsIfTheLatentSystemChanged) {
  Observer running(watched::kModel);
  for (int k = 0; k < 300; ++k) (void)running.step(wave(k));

  const watched::Model model = retrained();
  Observer next = exchanged(running, model), alone(model);
  for (int k = 0; k < 300; ++k) (void)alone.step(wave(k));
  EXPECT_EQ(next.estimate()[0], alone.estimate()[0]) << "as if the new map had flown from the start";

  watched::Model faster = model;
  faster.latent.step.a_minus_1[0] *= 2.0F;
  Observer again = exchanged(running, faster);
  EXPECT_EQ(again.latent()[0], Observer(faster).latent()[0]);
  EXPECT_NE(again.latent()[0], running.latent()[0]);
}

}  // namespace
}  // namespace nlo::examples
