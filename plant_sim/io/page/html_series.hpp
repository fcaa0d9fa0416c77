// SPDX-License-Identifier: Apache-2.0
// A signal's samples in few bytes, for a page that carries its own data.
//
//   q = round(value / resolution), d = q[i] - q[i-1] (q[-1] = 0), z = d >= 0 ? 2 d : -2 d - 1, z in LEB128, all in
//   base64
//
// Rounding is done on the value, not on the difference, so errors do not add up. html/series.js reads it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace voltlap::plant {

class HtmlSeries {
 public:
  /// `resolution` > 0, in the signal's unit. Values beyond +-2^31 resolutions are clamped; one that is no number is
  /// 0.
  HtmlSeries(std::string name, double resolution) : name_(std::move(name)), resolution_(resolution) {}

  void add(double value);
  /// Keeps the first of every two samples.
  void halve();

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] double resolution() const { return resolution_; }
  [[nodiscard]] std::size_t size() const { return steps_.size(); }
  [[nodiscard]] std::string base64() const;

 private:
  std::string name_;
  double resolution_;
  std::vector<std::int32_t> steps_;
};

}  // namespace voltlap::plant
