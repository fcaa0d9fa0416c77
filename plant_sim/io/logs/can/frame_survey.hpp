// SPDX-License-Identifier: Apache-2.0
// What is in a recording of a CAN bus: which frames on which bus, how often, how regularly; how full the buses were;
// the ranges of the signals that DBC files know.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/logs/can/can_recording.hpp"
#include "io/logs/can/checksum_search.hpp"
#include "io/logs/can/dbc_set.hpp"

namespace voltlap::plant {

/// One signal of the frames of one identifier on one bus.
struct SignalSurvey {
  std::size_t count = 0;         ///< values that the DBC does not call invalid
  std::size_t invalid = 0;       ///< values by which the sender says that it has none
  std::size_t beyond_range = 0;  ///< of `count`: outside the DBC's [min|max]
  std::size_t not_finite = 0;    ///< floating-point signals without a number
  double min = 0.0, max = 0.0, sum = 0.0;
  std::size_t first_beyond_line = 0;

  [[nodiscard]] double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0.0; }
};

/// The frames of one identifier on one bus.
struct FrameSurvey {
  const CompiledMessage* message = nullptr;  ///< nullptr: no DBC knows it
  std::size_t count = 0;
  double first_s = 0.0, last_s = 0.0;
  double longest_gap_s = 0.0, longest_gap_at_s = 0.0;
  unsigned length_min = RecordedFrame::kMostBytes, length_max = 0;
  std::size_t too_short = 0;  ///< frames shorter than the DBC says
  bool flexible = false;
  double interval_sum_s = 0.0, interval_square_sum = 0.0;
  std::uint64_t bits = 0;
  std::vector<SignalSurvey> signals;  ///< as in the message
  ChecksumSearch checksum;

  /// Mean interval, and how far single ones are from it (rms) [s]; 0 for a single frame.
  [[nodiscard]] double interval_s() const;
  [[nodiscard]] double jitter_s() const;
  /// A gap is a silence of ten usual intervals and half a second.
  [[nodiscard]] bool has_gap() const;
  /// Mean interval without the longest [s].
  [[nodiscard]] double usual_interval_s() const;
};

struct RecordingSurvey {
  CanSummary summary;
  std::string format;
  std::map<std::pair<std::string, std::uint32_t>, FrameSurvey> frames;  ///< by bus and identifier

  [[nodiscard]] double duration_s() const { return summary.end_s - summary.begin_s; }
  /// Bits of a bus in the time of the recording, of `bit_rate`; stuff bits counted. CAN FD frames are not in it.
  [[nodiscard]] double load_pct(const std::string& bus, double bit_rate) const;
};

/// Reads the recording to its end. `progress` is called now and then with the number of frames.
[[nodiscard]] RecordingSurvey survey(CanRecording& recording, const DbcSet& dbc,
                                     const std::function<void(std::size_t)>& progress);

}  // namespace voltlap::plant
