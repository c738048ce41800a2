// SPDX-License-Identifier: MIT
#include "trainer/learn/training/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {

namespace {

constexpr char kMagic[] = "nlo checkpoint 2\n";
constexpr std::size_t kMagicSize = sizeof(kMagic) - 1;

class Writer {
 public:
  template <class T>
  void value(const T& v) {
    text.append(reinterpret_cast<const char*>(&v), sizeof(T));
  }
  template <class T>
  void array(const std::vector<T>& v) {
    value(static_cast<std::uint64_t>(v.size()));
    text.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T));
  }
  std::string text;
};

struct Damaged {};

/// Reads the bytes of a checkpoint. Throws Damaged if they end early.
class Reader {
 public:
  Reader(const std::string& text, std::size_t at, std::size_t end) : text_(text), at_(at), end_(end) {}
  template <class T>
  void value(T& v) {
    take(&v, sizeof(T));
  }
  template <class T>
  void array(std::vector<T>& v) {
    std::uint64_t size = 0;
    value(size);
    if (size > (end_ - at_) / sizeof(T)) throw Damaged();
    v.resize(size);
    take(v.data(), size * sizeof(T));
  }
  bool at_end() const { return at_ == end_; }

 private:
  void take(void* to, std::size_t bytes) {
    if (bytes > end_ - at_) throw Damaged();
    if (bytes > 0) std::memcpy(to, text_.data() + at_, bytes);
    at_ += bytes;
  }
  const std::string& text_;
  std::size_t at_, end_;
};

/// Lists the fields once, for reading and for writing.
template <class Archive, class State>
void exchange(Archive& archive, State& state) {
  archive.value(state.step);
  archive.value(state.elapsed_s);
  archive.value(state.best_rmse);
  archive.value(state.returned_at);
  archive.array(state.parameters);
  archive.array(state.memory);
  archive.array(state.average);
  archive.array(state.best);
}

template <class Archive, class Row>
void exchange_row(Archive& archive, Row& row) {
  archive.value(row.step);
  archive.value(row.elapsed_s);
  archive.value(row.loss);
  archive.value(row.train_rmse);
  archive.value(row.validation_rmse);
  archive.value(row.learning_rate);
  archive.array(row.eigenvalues);
}

bool fits(const TrainingState& state, const CheckpointOwner& owner) {
  return state.parameters.size() == owner.parameters && state.average.size() == owner.parameters &&
         state.best.size() == owner.parameters && state.memory.size() == owner.memory &&
         std::all_of(state.metrics.begin(), state.metrics.end(),
                     [&](const MetricsRow& row) { return row.eigenvalues.size() == owner.eigenvalues; });
}

/// Checks conditions that every checkpoint written by a training satisfies.
bool is_plausible(const TrainingState& state) {
  const auto is_time = [](double seconds) { return std::isfinite(seconds) && seconds >= 0.0; };
  std::int64_t before = -1;
  for (const MetricsRow& row : state.metrics) {
    if (row.step <= before || row.step > state.step || !is_time(row.elapsed_s)) return false;
    before = row.step;
  }
  return state.step >= 0 && state.returned_at >= -1 && state.returned_at <= state.step && !state.metrics.empty() &&
         is_time(state.elapsed_s) && std::isfinite(state.best_rmse) &&
         std::all_of(state.best.begin(), state.best.end(), [](float p) { return std::isfinite(p); });
}

}  // namespace

std::uint64_t fingerprint(const void* data, std::size_t bytes, std::uint64_t start) {
  std::uint64_t hash = start;
  const auto* p = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < bytes; ++i) hash = (hash ^ p[i]) * 0x100000001b3ULL;
  return hash;
}

void write_checkpoint(const TrainingState& state, std::uint64_t experiment, const std::string& path) {
  Writer writer;
  writer.text = kMagic;
  writer.value(experiment);
  exchange(writer, state);
  writer.value(static_cast<std::uint64_t>(state.metrics.size()));
  for (const MetricsRow& row : state.metrics) exchange_row(writer, row);
  writer.value(fingerprint(writer.text.data(), writer.text.size()));
  codegen::write_file_atomically(path, writer.text);
}

TrainingState read_checkpoint(const std::string& path, const CheckpointOwner& owner) {
  const std::string text = codegen::read_file(path);
  const auto fail = [&](const std::string& why) {
    throw codegen::InputError(path + ": " + why + "; start again without --resume");
  };
  if (text.size() < kMagicSize + 2 * sizeof(std::uint64_t) || text.compare(0, kMagicSize, kMagic) != 0) {
    fail("not a checkpoint of this version");
  }
  const std::size_t end = text.size() - sizeof(std::uint64_t);
  std::uint64_t sum = 0;
  std::memcpy(&sum, text.data() + end, sizeof sum);
  if (sum != fingerprint(text.data(), end)) fail("the checkpoint is damaged");
  TrainingState state;
  try {
    Reader reader(text, kMagicSize, end);
    std::uint64_t of = 0;
    reader.value(of);
    if (of != owner.fingerprint) fail("the checkpoint belongs to another experiment, seed or data set");
    exchange(reader, state);
    std::uint64_t rows = 0;
    reader.value(rows);
    for (std::uint64_t r = 0; r < rows; ++r) exchange_row(reader, state.metrics.emplace_back());
    if (!reader.at_end()) throw Damaged();
  } catch (const Damaged&) {
    fail("the checkpoint is damaged");
  }
  if (!fits(state, owner)) fail("its sizes do not fit the experiment");
  if (!is_plausible(state)) fail("the checkpoint is damaged");
  if (state.step > owner.steps)
    throw codegen::InputError(path + ": " + std::to_string(state.step) +
                              " steps are done and training.steps asks for " + std::to_string(owner.steps) +
                              "; ask for more, or start again without --resume");
  return state;
}

std::string metrics_csv(const std::vector<MetricsRow>& rows, int pairs) {
  std::string text = "step,elapsed_s,loss,train_rmse,validation_rmse,learning_rate";
  const std::size_t nz = rows.empty() ? 0 : rows.front().eigenvalues.size();
  const auto paired = static_cast<std::size_t>(2 * pairs);
  int number = 0;
  for (std::size_t r = 0; r < nz; r += r < paired ? 2 : 1) {
    const std::string name = ",lambda_" + std::to_string(++number);
    text += name + "_re" + name + "_im";
  }
  text += '\n';
  for (const MetricsRow& row : rows) {
    text += std::to_string(row.step);
    for (const double v : {row.elapsed_s, row.loss, row.train_rmse, row.validation_rmse, row.learning_rate}) {
      text += ',' + shortest_text(v);
    }
    for (std::size_t r = 0; r < nz; ++r) {
      text += ',' + shortest_text(row.eigenvalues[r]);
      if (r >= paired) text += ",0";
    }
    text += '\n';
  }
  return text;
}

bool has_checkpoint(const std::string& directory) {
  std::error_code ignored;  // an error is ignored here, because making the folder will report it
  return std::filesystem::exists(directory + "/checkpoint.bin", ignored);
}

}  // namespace nlo::trainer
