// SPDX-License-Identifier: Apache-2.0
// Shapes that may each be large are held to what references show along each signature; what no reference tells of, as
// the difference of two shapes that are nearly one, stays free.
#include "discrepancy/projections.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kRows = 1000.0;

/// Two shapes and a cause, all three nearly the same.
Design design_of_three() {
  Design out;
  out.comparison.channels.push_back({"voltage", Balance::kVoltage, "V", VectorXd()});
  for (int k = 0; k < 3; ++k) {
    Column column;
    column.cause = k < 2 ? -1 : 0;
    column.effect.assign(1, VectorXd::Ones(3));
    out.columns.push_back(column);
  }
  return out;
}

BlockSum said(const VectorXd& amounts) {
  BlockSum out = empty_sum(3);
  out.gram = kRows * (0.99 * MatrixXd::Ones(3, 3) + 0.01 * MatrixXd::Identity(3, 3));
  out.score = out.gram * amounts;
  out.energy = amounts.dot(out.score) + kRows;
  out.rows = kRows;
  return out;
}

}  // namespace

TEST_GROUP(Projections) {
  Design design = design_of_three();
  const std::vector<BlockSum> log{said(VectorXd::Zero(3))};
  VectorXd mean = VectorXd::Zero(3);
  MatrixXd variance = VectorXd({{1.0, 1.0, 0.0}}).asDiagonal();

  /// Variance of the log's projection on the cause, after three references with this much of the first shape each.
  double projected(const std::vector<double>& amounts) {
    std::vector<std::vector<BlockSum>> references;
    std::vector<std::size_t> teachers;
    for (const double amount : amounts) {
      teachers.push_back(references.size());
      references.push_back({said(VectorXd({{amount, 0.0, 0.0}}))});
    }
    bound_projections(design, log, references, teachers, mean, variance);
    const VectorXd onto = log[0].gram.row(2).transpose() / log[0].gram(2, 2);
    return onto.dot(variance * onto);
  }
};

TEST(Projections, AreAboutAsLargeAsInReferences) {
  const double small = projected({0.1, -0.1, 0.1});
  variance = VectorXd({{1.0, 1.0, 0.0}}).asDiagonal();
  const double large = projected({1.0, -1.0, 1.0});
  CHECK(small < 0.07);  // of 2; four tenths of a square of 0.1, and what all errors of the channel let expect
  CHECK(large > 10.0 * small);
  CHECK(large < 1.5);
}

TEST(Projections, LeaveWhatNoSignatureTellsOf) {
  projected({0.1, -0.1, 0.1});
  const VectorXd apart{{1.0, -1.0, 0.0}};
  const double difference = apart.dot(variance * apart);
  CHECK(difference > 1.9);  // of 2: the shapes differ by a tenth of what they share
}

TEST(Projections, HoldAMeanThatGoesBeyondThem) {
  mean = VectorXd({{2.0, 2.0, 0.0}});
  projected({0.1, -0.1, 0.1});
  CHECK(std::abs(mean(0) + mean(1)) < 0.1);
}

TEST(Projections, WhatALogsOwnStartTellsStaysPossibleBesideThem) {
  // The second shape is told by the log's start and goes with the first: what is learned of both must stay a variance.
  design.columns[1].of_start = true;
  variance(0, 1) = variance(1, 0) = 0.9;
  projected({0.1, -0.1, 0.1});
  CHECK(variance(0, 0) < 0.1);
  CHECK(variance(1, 1) < 0.3);  // of 1: nine tenths of it go with the first
  CHECK(variance(1, 1) > 0.19);
  CHECK(variance(0, 0) * variance(1, 1) >= variance(0, 1) * variance(1, 0));
}

TEST(Projections, StayFreeInAChannelThatNoReferenceHas) {
  bound_projections(design, log, {{empty_sum(3)}}, {0}, mean, variance);
  DOUBLES_EQUAL(1.0, variance(0, 0), 0.0);
  DOUBLES_EQUAL(1.0, variance(1, 1), 0.0);
}

TEST(Projections, NoiseOfReferencesIsNoErrorOfTheModel) {
  // White noise of a thousand rows has a thousandth of its square along a signature, an error 0.15 of its size.
  const double noise_alone = projected({0.0, 0.0, 0.0});
  CHECK(noise_alone < 0.002);  // 0.014 if all of the references' squares were errors
  CHECK(noise_alone > 0.5 / kRows);  // what is slow hides in noise
}

TEST(Projections, NoiseHidesAnErrorOfTheChargeWholly) {
  const double of_voltage = projected({0.0, 0.0, 0.0});
  variance = VectorXd({{1.0, 1.0, 0.0}}).asDiagonal();
  design.comparison.channels[0].balance = Balance::kCharge;
  CHECK(projected({0.0, 0.0, 0.0}) > 4.0 * of_voltage);
}

TEST(Projections, OfOtherLogsDoNotBoundWhatThisLogsStartShows) {
  design.columns[0].of_start = true;
  projected({0.1, -0.1, 0.1});
  DOUBLES_EQUAL(1.0, variance(0, 0), 0.0);
  CHECK(variance(1, 1) < 0.1);
}

TEST(Projections, OfAnErrorThatIsOneNumberADriveAreKnownByAsManyNumbers) {
  design.comparison.channels[0].balance = Balance::kCharge;
  const double square = projected({0.3, -0.3, 0.3});
  CHECK(square > 0.12);  // 0.072 with the margin of errors that each drive tells often
  CHECK(square < 0.20);
}
