// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/banded_system.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using voltlap::plant::BandedSystem;

namespace {

using Matrix = std::vector<std::vector<double>>;

/// B B^T + I of a lower band B: positive definite, within the band.
Matrix drawn_matrix(std::size_t n, std::size_t half_width, std::mt19937_64& draw) {
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  Matrix b(n, std::vector<double>(n, 0.0)), a = b;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i - std::min(i, half_width); j <= i; ++j) b[i][j] = entry(draw);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k) a[i][j] += b[i][k] * b[j][k];
    }
    a[i][i] += 1.0;
  }
  return a;
}

BandedSystem system_of(const Matrix& a, std::size_t half_width) {
  BandedSystem system(a.size(), half_width);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = i - std::min(i, half_width); j <= i; ++j) system.add(j, i, a[i][j]);
  }
  return system;
}

}  // namespace

TEST_GROUP(BandedSystem){};

TEST(BandedSystem, SolvesAndInvertsDrawnSystemsOfEveryWidth) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 draw(seed);
    const std::size_t n = 1 + seed % 23, half_width = seed % 7;
    const Matrix a = drawn_matrix(n, half_width, draw);
    BandedSystem system = system_of(a, half_width);
    CHECK_TEXT(system.factorise(), ("seed " + std::to_string(seed)).c_str());
    system.invert_band();
    for (std::size_t column = 0; column < n; ++column) {
      std::vector<double> unit(n, 0.0);
      unit[column] = 1.0;
      const std::vector<double> x = system.solved(unit);
      for (std::size_t i = 0; i < n; ++i) {
        double product = 0.0;
        for (std::size_t k = 0; k < n; ++k) product += a[i][k] * x[k];
        DOUBLES_EQUAL_TEXT(unit[i], product, 1e-9, ("seed " + std::to_string(seed)).c_str());
        const bool in_band = (i > column ? i - column : column - i) <= half_width;
        if (!in_band) continue;
        DOUBLES_EQUAL_TEXT(x[i], system.inverse(i, column), 1e-9, ("seed " + std::to_string(seed)).c_str());
      }
    }
  }
}

TEST(BandedSystem, KnowsItsDeterminant) {
  BandedSystem system(2, 1);
  system.add(0, 0, 4.0);
  system.add(1, 1, 3.0);
  system.add(0, 1, 1.0);
  CHECK(system.factorise());
  DOUBLES_EQUAL(std::log(11.0), system.log_determinant(), 1e-12);
}

TEST(BandedSystem, SaysThatAMatrixIsNotPositiveDefinite) {
  BandedSystem system(2, 1);
  system.add(0, 0, 1.0);
  system.add(1, 1, 1.0);
  system.add(0, 1, 2.0);
  CHECK_FALSE(system.factorise());
}
