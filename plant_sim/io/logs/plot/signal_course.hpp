// SPDX-License-Identifier: Apache-2.0
// What a signal does over a recording, gathered sample by sample without keeping any of them: how far it goes, how it
// moves, what a gap is for it.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace voltlap::plant {

class SignalCourse {
 public:
  /// Time never decreases. A value that is no number is a sample without a value.
  void add(double time_s, double value);

  [[nodiscard]] std::size_t samples() const { return samples_; }  ///< with a value
  [[nodiscard]] std::size_t missing() const { return missing_; }  ///< without
  [[nodiscard]] double first_s() const { return first_s_; }
  [[nodiscard]] double last_s() const { return last_s_; }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  [[nodiscard]] double low_at_s() const { return low_at_s_; }
  [[nodiscard]] double high_at_s() const { return high_at_s_; }
  [[nodiscard]] double last() const { return last_; }
  [[nodiscard]] double range() const { return high_ - low_; }
  [[nodiscard]] std::size_t changes() const { return changes_; }
  [[nodiscard]] bool is_constant() const { return changes_ == 0; }

  /// Decimals of its values, at most 6.
  [[nodiscard]] int decimals() const { return decimals_; }
  /// Usual interval between samples [s], to a factor of two; 0 with less than two samples.
  [[nodiscard]] double usual_interval_s() const;
  /// Nothing is known of the signal over a longer interval than this between two samples [s].
  [[nodiscard]] double gap_s() const;
  /// It holds few values, or keeps each for long: a value lasts until the next.
  [[nodiscard]] bool is_stepped() const;
  /// It counts up by the same step nearly always: a rolling counter, a clock.
  [[nodiscard]] bool is_counter() const;
  /// It jumps about its whole range from sample to sample: a checksum.
  [[nodiscard]] bool is_noise() const;

 private:
  static constexpr std::size_t kFew = 16;
  void add_change(double value);
  void add_interval(double interval_s);
  [[nodiscard]] double interval_quantile(double part) const;

  std::size_t samples_ = 0, missing_ = 0, changes_ = 0, same_steps_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, last_ = 0.0;
  double low_ = 0.0, high_ = 0.0, low_at_s_ = 0.0, high_at_s_ = 0.0;
  double travel_ = 0.0, step_ = 0.0;
  int decimals_ = 0;
  std::array<double, kFew> values_{};  ///< the first different ones
  std::size_t different_ = 0;          ///< kFew + 1: more than that
  std::array<std::uint32_t, 48> intervals_{};  ///< by powers of two from kShortest
};

}  // namespace voltlap::plant
