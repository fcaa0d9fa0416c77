// SPDX-License-Identifier: Apache-2.0
// A channel of a recording as a receiver on a bus has it at a moment: its latest sample, with its age. What is masked
// is no sample; a value that is too old is none.
#pragma once
#include <cstddef>
#include <vector>

#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

class HeldChannel {
 public:
  /// No channel: never a value.
  HeldChannel() = default;
  /// A value counts for `longest_s`.
  HeldChannel(const Channel* channel, double longest_s);

  /// Forwards only.
  void advance(double time_s);

  [[nodiscard]] bool recorded() const { return channel_ != nullptr; }
  [[nodiscard]] bool known() const { return seen_ && now_s_ - sample_s_ <= longest_s_; }
  [[nodiscard]] double value() const { return value_; }      ///< of the latest sample
  [[nodiscard]] double sampled_s() const { return sample_s_; }
  [[nodiscard]] double longest_s() const { return longest_s_; }
  [[nodiscard]] double first_s() const;                      ///< of the first sample; infinite without one
  [[nodiscard]] double last_s() const;

 private:
  const Channel* channel_ = nullptr;
  std::size_t next_ = 0;
  bool seen_ = false;
  double now_s_ = 0.0, sample_s_ = 0.0, value_ = 0.0, longest_s_ = 0.0;
};

/// The interval that nine of ten samples of these channels stay within: recorders write in bursts and lose frames.
[[nodiscard]] double usual_interval_s(const std::vector<const Channel*>& channels);

/// The latest value of a channel at a time; NaN before the first.
[[nodiscard]] double value_at(const Channel& channel, double time_s);

}  // namespace voltlap::plant
