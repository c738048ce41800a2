// SPDX-License-Identifier: MIT
#include "trainer/symmetry/symmetry.h"

#include <algorithm>
#include <utility>

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

int row_of(const std::string& name, const std::vector<codegen::Channel>& channels) {
  const auto found = std::ranges::find(channels, name, &codegen::Channel::name);
  return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

MovedRows rows_of(const SymmetryConfig& config, const SymmetryKind& kind,
                  const std::vector<codegen::Channel>& channels) {
  MovedRows moved;
  for (const std::vector<std::string>& names : config.vectors) {
    std::vector<int> rows;
    for (const std::string& name : names) rows.push_back(row_of(name, channels));
    if (std::ranges::min(rows) >= 0) moved.vectors.push_back(std::move(rows));
  }
  for (const std::string& name : config.channels) {
    const int plain = row_of(name, channels), sine = row_of(name + "_sin", channels);
    if (kind.channels == SymmetryKind::Channels::kScalars) {
      if (plain >= 0 || sine >= 0) moved.vectors.push_back({plain >= 0 ? plain : sine});  // its cosine is even
    } else if (plain >= 0) {
      moved.angles.push_back({plain, false, channels[static_cast<std::size_t>(plain)].wrap});
    } else if (sine >= 0) {
      moved.angles.push_back({sine, true});
    }
  }
  return moved;
}

/// Of readings alone: the others of one symmetry.
std::vector<RowMap> other_maps(const Symmetry& symmetry, Index readings) {
  std::vector<RowMap> maps;
  for (const Element& element : symmetry.kind->others(symmetry.components, symmetry.fold))
    maps.emplace_back(static_cast<int>(readings)).then(symmetry.readings, element);
  return maps;
}

}  // namespace

Symmetry on_channels(const SymmetryConfig& config, const std::vector<codegen::Channel>& readings,
                     const std::vector<codegen::Channel>& states) {
  const SymmetryKind& kind = symmetry_kind(config.kind);
  const int components = kind.components != kAnyLength ? kind.components
                         : config.vectors.empty()      ? 0
                                                       : static_cast<int>(config.vectors.front().size());
  return {&kind, components, config.fold, rows_of(config, kind, readings), rows_of(config, kind, states)};
}

std::vector<Symmetry> on_channels(const std::vector<SymmetryConfig>& configs,
                                  const std::vector<codegen::Channel>& readings,
                                  const std::vector<codegen::Channel>& states) {
  std::vector<Symmetry> all;
  for (const SymmetryConfig& config : configs) all.push_back(on_channels(config, readings, states));
  return all;
}

RowMap::RowMap(int rows) {
  for (int row = 0; row < rows; ++row) rows_.push_back({{{row, 1.0}}});
}

void RowMap::then(const MovedRows& moved, const Element& element) {
  const auto apply = [&](const std::vector<int>& rows, const MatrixXd& matrix) {
    std::vector<Row> images(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < rows.size(); ++j) {
        const double factor = matrix(static_cast<Index>(i), static_cast<Index>(j));
        if (factor == 0.0) continue;
        const Row& from = rows_[static_cast<std::size_t>(rows[j])];
        for (const Term& term : from.terms) images[i].terms.push_back({term.row, factor * term.factor});
        images[i].offset += factor * from.offset;
      }
    for (std::size_t i = 0; i < rows.size(); ++i) rows_[static_cast<std::size_t>(rows[i])] = std::move(images[i]);
  };
  for (const std::vector<int>& rows : moved.vectors) apply(rows, element.matrix);
  for (const MovedRows::Angle& angle : moved.angles) {
    if (angle.sincos)  // (cosine, sine) turns as a vector of the plane
      apply({angle.row + 1, angle.row}, element.matrix);
    else
      rows_[static_cast<std::size_t>(angle.row)].offset += element.turns * angle.wrap;
  }
}

MatrixXd RowMap::values(const MatrixXd& signal) const {
  MatrixXd result = derivatives(signal);
  for (std::size_t row = 0; row < rows_.size(); ++row) result.row(static_cast<Index>(row)).array() += rows_[row].offset;
  return result;
}

MatrixXd RowMap::derivatives(const MatrixXd& signal) const {
  MatrixXd result = signal;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    result.row(static_cast<Index>(row)).setZero();
    for (const Term& term : rows_[row].terms) result.row(static_cast<Index>(row)) += term.factor * signal.row(term.row);
  }
  return result;
}

Image image_of(const Symmetry& symmetry, const Element& element, int readings, int states) {
  Image image{RowMap(readings), RowMap(states)};
  image.readings.then(symmetry.readings, element);
  image.states.then(symmetry.states, element);
  return image;
}

Image draw_image(const std::vector<Symmetry>& symmetries, int readings, int states, const Uniform& uniform) {
  Image image{RowMap(readings), RowMap(states)};
  for (const Symmetry& symmetry : symmetries) {
    const Element element = symmetry.kind->draw(symmetry.components, symmetry.fold, uniform);
    image.readings.then(symmetry.readings, element);
    image.states.then(symmetry.states, element);
  }
  return image;
}

std::vector<Image> other_images(const std::vector<Symmetry>& symmetries, int readings, int states) {
  std::vector<Image> images;
  for (const Symmetry& symmetry : symmetries)
    for (const Element& element : symmetry.kind->others(symmetry.components, symmetry.fold))
      images.push_back(image_of(symmetry, element, readings, states));
  return images;
}

VectorXd mean_of_images(const std::vector<Symmetry>& symmetries, const VectorXd& readings) {
  VectorXd mean = readings;
  for (const Symmetry& symmetry : symmetries) {
    const std::vector<RowMap> others = other_maps(symmetry, readings.size());
    VectorXd sum = mean;
    for (const RowMap& image : others) sum += image.derivatives(mean);
    mean = sum / static_cast<double>(others.size() + 1);
  }
  return mean;
}

void widen_by_images(const std::vector<Symmetry>& symmetries, VectorXd& low, VectorXd& high) {
  for (const Symmetry& symmetry : symmetries) {
    const VectorXd before_low = low, before_high = high;
    for (const RowMap& image : other_maps(symmetry, low.size()))
      for (Index row = 0; row < low.size(); ++row) {
        const auto& [terms, offset] = image.row(static_cast<int>(row));
        double least = offset, most = offset;
        bool empty = false;
        for (const RowMap::Term& term : terms) {
          const double a = term.factor * before_low(term.row), b = term.factor * before_high(term.row);
          empty = empty || before_low(term.row) > before_high(term.row);
          least += std::min(a, b);
          most += std::max(a, b);
        }
        if (empty) continue;
        low(row) = std::min(low(row), least);
        high(row) = std::max(high(row), most);
      }
  }
}

}  // namespace nlo::trainer
