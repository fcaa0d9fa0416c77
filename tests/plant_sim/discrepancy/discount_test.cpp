// SPDX-License-Identifier: Apache-2.0
// What is known beforehand is taken off what a log tells: exact where both span many powers of ten.
#include "discrepancy/discount.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kShapes = 12;
constexpr double kGram = 1e7, kOwn = 100.0;  // of each shape; of what the cause has that no shape has

}  // namespace

/// Shapes at right angles, known by V = U v U' with v from 1e-3 to 1e5; a cause that is their sum, and a little of its own.
/// The cause keeps kOwn + sum (U'c)^2 g / (1 + g v).
TEST_GROUP(Discount) {
  MatrixXd gram = MatrixXd::Zero(kShapes + 1, kShapes + 1), variance = gram;
  double kept = kOwn;

  void setup() override {
    const VectorXd axis = VectorXd::LinSpaced(kShapes, 0.3, 2.0).normalized();
    const MatrixXd u = MatrixXd::Identity(kShapes, kShapes) - 2.0 * axis * axis.transpose();
    VectorXd v(kShapes);
    for (Index k = 0; k < kShapes; ++k) v(k) = std::pow(10.0, -3.0 + 8.0 * static_cast<double>(k) / (kShapes - 1));
    variance.topLeftCorner(kShapes, kShapes) = u * v.asDiagonal() * u.transpose();
    gram.topLeftCorner(kShapes, kShapes).diagonal().setConstant(kGram);
    gram.col(kShapes).head(kShapes).setConstant(kGram);
    gram.row(kShapes).head(kShapes).setConstant(kGram);
    gram(kShapes, kShapes) = kShapes * kGram + kOwn;
    const VectorXd along = u.transpose() * VectorXd::Ones(kShapes);
    for (Index k = 0; k < kShapes; ++k) kept += along(k) * along(k) * kGram / (1.0 + kGram * v(k));
  }
};

TEST(Discount, LeavesOfACauseWhatIsNotKnownBeforehand) {
  const MatrixXd left = Discount(gram, variance).information();
  DOUBLES_EQUAL(kept, left(kShapes, kShapes), 1e-6 * kept);
  CHECK((left - left.transpose()).cwiseAbs().maxCoeff() == 0.0);
  const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(left).eigenvalues()(0);
  CHECK(least > -1e-12 * kGram);
}

TEST(Discount, ScoresAreLeftAsInformationIs) {
  // A log that holds twice the cause and nothing else: its score is twice a column of the information.
  const Discount discount(gram, variance);
  const VectorXd score = discount.score(2.0 * gram.col(kShapes)).col(0);
  const VectorXd expected = 2.0 * discount.information().col(kShapes);
  CHECK((score - expected).cwiseAbs().maxCoeff() < 1e-6 * kept);
}

TEST(Discount, AmountsAndWhatIsLeftMakeTheWhole) {
  const Discount discount(gram, variance);
  const VectorXd score = VectorXd::LinSpaced(kShapes + 1, -1e3, 2e3);
  const VectorXd amounts = discount.amounts(score).col(0), left = discount.score(score).col(0);
  CHECK((score - left - gram * amounts).cwiseAbs().maxCoeff() < 1e-6);
  DOUBLES_EQUAL(score.dot(amounts), discount.whitened(score).squaredNorm(), 1e-9 * std::abs(score.dot(amounts)));
}

TEST(Discount, VariancesAloneAreADiagonal) {
  const VectorXd variances = variance.diagonal();
  const Discount by_variances = Discount::by_variances(gram, variances);
  const Discount whole(gram, MatrixXd(variances.asDiagonal()));
  const MatrixXd a = by_variances.information(), b = whole.information();
  CHECK((a - b).cwiseAbs().maxCoeff() < 1e-6 * a.cwiseAbs().maxCoeff());
  const VectorXd score = VectorXd::LinSpaced(kShapes + 1, -1e3, 2e3);
  CHECK((by_variances.amounts(score) - whole.amounts(score)).cwiseAbs().maxCoeff() < 1e-9);
}

TEST(Discount, KnowingNothingTakesNothing) {
  const MatrixXd left = Discount(gram, MatrixXd::Zero(kShapes + 1, kShapes + 1)).information();
  CHECK((left - gram).cwiseAbs().maxCoeff() == 0.0);
}
