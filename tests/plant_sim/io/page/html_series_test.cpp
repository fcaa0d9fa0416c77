// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_series.hpp"

#include <openssl/evp.h>

#include <cmath>
#include <limits>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// What html/series.js does.
std::vector<double> decoded(const HtmlSeries& series) {
  const std::string text = series.base64();
  std::vector<unsigned char> bytes(text.size());
  EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  std::vector<double> out;
  std::int64_t sum = 0;
  for (std::size_t at = 0; out.size() < series.size();) {
    std::uint64_t value = 0;
    for (unsigned shift = 0;; shift += 7) {
      value |= static_cast<std::uint64_t>(bytes[at] & 0x7FU) << shift;
      if ((bytes[at++] & 0x80U) == 0) break;
    }
    const auto half = static_cast<std::int64_t>(value / 2);
    sum += value % 2 != 0 ? -half - 1 : half;
    out.push_back(static_cast<double>(sum) * series.resolution());
  }
  return out;
}

HtmlSeries series_of(double resolution, const std::vector<double>& values) {
  HtmlSeries series("signal", resolution);
  for (const double value : values) series.add(value);
  return series;
}

}  // namespace

TEST_GROUP(HtmlSeries){};

TEST(HtmlSeries, ValuesComeBackWithinHalfAResolution) {
  std::vector<double> values;
  for (int i = 0; i < 5000; ++i) values.push_back(300.0 * std::sin(0.37 * i) + 1e4 * std::sin(0.001 * i));
  const auto back = decoded(series_of(0.1, values));
  for (std::size_t i = 0; i < values.size(); ++i) DOUBLES_EQUAL(values[i], back[i], 0.05 + 1e-9);
}

TEST(HtmlSeries, ADriftBelowTheResolutionIsNotLost) {
  std::vector<double> values;
  for (int i = 0; i <= 1000; ++i) values.push_back(0.04 * i);
  DOUBLES_EQUAL(40.0, decoded(series_of(0.1, values)).back(), 1e-9);
}

TEST(HtmlSeries, ACalmSignalTakesOneByteASample) {
  const std::string text = series_of(0.1, std::vector<double>(3000, 0.05)).base64();
  LONGS_EQUAL(4000, text.size());
}

TEST(HtmlSeries, WhatIsNoNumberIsZeroAndWhatIsTooLargeIsClamped) {
  const double infinite = std::numeric_limits<double>::infinity();
  const auto back = decoded(series_of(1.0, {std::nan(""), infinite, 1e300, -1e300, 5.0}));
  DOUBLES_EQUAL(0.0, back[0], 0.0);
  DOUBLES_EQUAL(0.0, back[1], 0.0);
  DOUBLES_EQUAL(2147483647.0, back[2], 0.0);
  DOUBLES_EQUAL(-2147483647.0, back[3], 0.0);
  DOUBLES_EQUAL(5.0, back[4], 0.0);
}

TEST(HtmlSeries, HalvingKeepsTheFirstOfEveryTwo) {
  HtmlSeries series = series_of(1.0, {0, 1, 2, 3, 4});
  series.halve();
  const auto back = decoded(series);
  LONGS_EQUAL(3, back.size());
  DOUBLES_EQUAL(2.0, back[1], 0.0);
  DOUBLES_EQUAL(4.0, back[2], 0.0);
}

TEST(HtmlSeries, NoSamplesAreNoText) {
  STRCMP_EQUAL("", HtmlSeries("signal", 1.0).base64().c_str());
}
