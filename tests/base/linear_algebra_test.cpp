// SPDX-License-Identifier: MIT
#include "codegen/base/linear_algebra.h"

#include <gtest/gtest.h>

#include <limits>

namespace nlo::codegen {
namespace {

using Eigen::MatrixXd;

// Matrices of order 1 and size 3: a few roundings of 1.
constexpr double kRounding = 1e-14;

TEST(LinearAlgebra, SquareRootTimesItsTransposeIsTheMatrix) {
  MatrixXd a(3, 3);
  a << 2.0, 0.5, 0.1, 0.5, 1.0, -0.3, 0.1, -0.3, 0.7;
  const MatrixXd s = square_root(a);
  EXPECT_LT((s * s.transpose() - a).cwiseAbs().maxCoeff(), kRounding);
}

TEST(LinearAlgebra, FindsASquareRootOfASingularMatrix) {
  const MatrixXd column =
      (MatrixXd(3, 1) << 0.1, -2.0, 1.0).finished();  // the largest entry is not the first: pivoting is needed
  const MatrixXd a = column * column.transpose();
  const MatrixXd s = square_root(a);
  EXPECT_LT((s * s.transpose() - a).cwiseAbs().maxCoeff(), kRounding * a.maxCoeff());
  EXPECT_TRUE(square_root(MatrixXd::Zero(2, 2)).isZero(0.0));
}

TEST(LinearAlgebra, SquareRootOfANonFiniteMatrixIsNotFinite) {
  MatrixXd a = MatrixXd::Identity(2, 2);
  a(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(square_root(a).allFinite());
}

TEST(LinearAlgebra, LeastSquaresOfTheIdentityIsThePseudoInverse) {
  MatrixXd a(3, 2);
  a << 1.0, 2.0, 0.0, 1.0, -1.0, 0.5;
  const MatrixXd x = least_squares(a, MatrixXd::Identity(3, 3));
  EXPECT_LT((x * a - MatrixXd::Identity(2, 2)).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_LT((a * x - (a * x).transpose()).cwiseAbs().maxCoeff(), kRounding) << "Moore and Penrose's third condition";
}

TEST(LinearAlgebra, LeastSquaresOfADeficientMatrixIsTheShortestSolution) {
  const MatrixXd a = (MatrixXd(2, 2) << 1.0, 1.0, 1.0, 1.0).finished(), b = (MatrixXd(2, 1) << 1.0, 3.0).finished();
  EXPECT_LT((least_squares(a, b) - MatrixXd::Ones(2, 1)).cwiseAbs().maxCoeff(), kRounding);
}

}  // namespace
}  // namespace nlo::codegen
