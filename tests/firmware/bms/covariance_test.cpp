// SPDX-License-Identifier: Apache-2.0
#include "bms/covariance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "CppUTest/TestHarness.h"

using namespace voltlap::bms;

namespace {

/// E of the header, a slope of more than 1000 V/A counts as that, and what is asked of it; both in the unit of zz.
struct Twin {
  double explained, asked;
  double lost;  ///< share of E that integers leave out at most, of slope and sag
};

Twin twin(const Covariance& c, std::int64_t sag, std::int64_t least) {
  const double s = static_cast<double>(sag), xx = std::max(static_cast<double>(c.xx), 250'000.0);
  const double squared = static_cast<double>(least) * static_cast<double>(least);
  return {std::min(s / xx, 1e4) * s / 256.0, std::max(squared / 256.0, static_cast<double>(c.zz) / 4.0),
          1e-3 * xx / s + 256.0 / s};
}

}  // namespace

TEST_GROUP(Covariance) {
  std::mt19937_64 random{11};
  /// Alike over all orders of magnitude.
  std::int64_t drawn(double most) {
    return static_cast<std::int64_t>(std::exp(std::uniform_real_distribution(0.0, std::log(most))(random)));
  }
};

// BMS-060, BMS-066
TEST(Covariance, ExplainsWhatItsTwinInDoublePrecisionDoesUpToItsLargestNumbers) {
  int explained = 0, held = 0, near = 0;
  for (int draw = 0; draw < 200'000; ++draw) {
    const Covariance c{0, 0, drawn(1.6e13), 0, drawn(3.6e12)};
    const std::int64_t sag = drawn(1.2e14), least = 50 * (1 + draw % 144);
    const auto [full, asked, lost] = twin(c, sag, least);
    const bool yes = full * (1.0 - lost) > asked + 2.0, no = full < asked - 2.0;
    near += yes || no ? 0 : 1;  // roundings decide
    if (yes || no) CHECK_EQUAL(yes, explains(c, sag, least));
    explained += yes ? 1 : 0;
    held += static_cast<double>(sag) > 1e4 * std::max(static_cast<double>(c.xx), 250'000.0) ? 1 : 0;
  }
  std::printf("of 200000 covariances %d explain, %d are beyond the steepest slope, %d too near to say\n", explained,
              held, near);
  CHECK(explained > 20'000 && held > 1'000 && near < 20'000);
}

TEST(Covariance, OnlyAPositiveSagExplainsAnything) {
  const Covariance c{0, 0, 1'000'000, 0, 0};
  CHECK(explains(c, 1'000'000'000, 50));
  for (const std::int64_t sag : {std::int64_t{0}, std::int64_t{-1'000'000'000}}) CHECK_FALSE(explains(c, sag, 50));
}
