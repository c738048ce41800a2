// SPDX-License-Identifier: MIT
// Proves a bound of the spectral norm of a network's Jacobian over a box of its inputs. For small boxes the bound
// becomes sharp. The search in lipschitz.h uses it.
//
// Let D_l(x) be the slopes of layer l, and C_l constant slopes at the centre. Then differences of products telescope:
//   J(x) - J_C = sum over l of A_l (D_l(x) - C_l) V_l(x),   A_l = W_L C_(L-1) ... W_(l+1),   V_l = W_l D_(l-1) ... W_1
// where V_l, the Jacobian of layer l's pre-activations, is bounded in the same way from the layers before it. The
// result is the smallest of three bounds:
//   norms     bounds |D_l - C_l| by the range of slopes and each factor by its spectral norm, as lipschitz_upper()
//             does. It is best for large boxes.
//   entries   uses the same factors, with absolute values entry by entry. It is best for small boxes and for relu.
//   linear    uses D_l - C_l = s_l V_l (x - c) + a remainder of second order. It keeps the linear part of J with its
//             signs. The norm of this part is a convex function of x, so it is largest at a corner of the box.
// Rounding is included (rounding.h): a sum of weights has an error of at most gamma times the sum of their sizes, with
// kSteepest for each slope. These sums are the same for all boxes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/activations.h"
#include "codegen/model/model.h"

namespace nlo::trainer {

struct LayerRange;
struct AffineValues;

/// A box of inputs: centre +- radius.
struct InputBox {
  Eigen::VectorXd centre, radius;
};

class JacobianEnclosure {
 public:
  /// Inputs p with in = inputs p, where `in` is the input of the network's features. The Jacobian is that of the
  /// outputs with respect to p, times `directions`.
  JacobianEnclosure(const codegen::Network& network, const Eigen::MatrixXd& inputs, Eigen::MatrixXd directions);

  struct Bound {
    double norm = 0.0;       ///< |J(p) directions| is at most this for every p of the box
    Eigen::Index split = 0;  ///< the input that should be halved next
    bool by_norms = true;    ///< false: it is not the smallest for any part of the box either
  };
  /// Without `norms`, which takes most of the time, only the other two bounds are computed.
  Bound over(const InputBox& box, bool norms = true) const;

  /// Bounds of the outputs over the box, and the input that should be halved next.
  struct Values {
    Eigen::VectorXd low, high;
    Eigen::Index split = 0;
  };
  Values values_over(const InputBox& box) const;

  /// Returns the ranges of every hidden layer over the box.
  std::vector<LayerRange> layers_over(const InputBox& box) const;
  /// Returns the input that should be halved next.
  Eigen::Index split_of(const std::vector<LayerRange>& ranges, const InputBox& box) const;

  /// These return the folded layers, bounds of the errors of their numbers, and the linear path beside them.
  const std::vector<codegen::DenseLayer>& layers() const { return layers_; }
  const std::vector<codegen::DenseLayer>& layer_roundings() const { return rounding_.layer; }
  const Eigen::MatrixXd& linear_path() const { return linear_path_; }
  const Eigen::MatrixXd& linear_path_rounding() const { return rounding_.linear_path; }

  /// The average of J directions between the box's centre c and any p in it. It maps p - c to the difference of the
  /// outputs. It lies in centre +- radius, entry by entry.
  struct Secants {
    Eigen::MatrixXd centre, radius;
  };
  Secants secants_over(const InputBox& box) const;

  /// Chooses a scaling of the neurons for which the bound by norms is small over this box, by a search that starts from
  /// a good guess. The scaling can then be used for smaller boxes, too; bounds hold for any scaling. Each of `rounds`
  /// computes two bounds per neuron.
  void balance(const InputBox& box, int rounds);

  /// Returns |J(p) directions| at one point.
  double at(const Eigen::VectorXd& p) const;

  /// Returns the multiply-adds of one over().
  double cost() const;

 private:
  struct Pieces;
  Pieces pieces_over(const InputBox& box) const;
  /// Returns the ranges of every hidden layer over the box. Sets `mid` to the Jacobian at the centre's slopes.
  std::vector<LayerRange> ranges_over(const InputBox& box, Eigen::MatrixXd& mid, AffineValues* values = nullptr) const;
  double bound_by_norms(const std::vector<LayerRange>& ranges) const;

  const codegen::ActivationRow* activation_;
  std::vector<codegen::DenseLayer> layers_;  ///< features, normalisation and scales folded in
  Eigen::MatrixXd linear_path_;              ///< n_out x n_p
  Eigen::MatrixXd directions_;
  std::vector<Eigen::VectorXd> balance_;  ///< per hidden layer, positive

  /// Bounds of rounding in the folded layers and in the results of over().
  struct Roundings {
    double gamma = 0.0;
    std::vector<codegen::DenseLayer> layer;  ///< for weights and bias
    Eigen::MatrixXd linear_path;
    std::vector<Eigen::MatrixXd> mid;                ///< errors of V at the centre's slopes; last entry: of J
    std::vector<double> mid_norm;                    ///< norms of the errors of mid times the directions
    std::vector<std::vector<Eigen::MatrixXd>> from;  ///< [m][l], l < m: errors of the map from layer l to layer m
    std::vector<std::vector<double>> from_norm;
  } rounding_;
};

}  // namespace nlo::trainer
