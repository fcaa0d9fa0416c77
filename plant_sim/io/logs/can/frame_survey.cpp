// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/frame_survey.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/demand.hpp"
#include "io/bus/frame_bits.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kOften = 50000;  // frames between two words about progress

std::uint64_t bits_of(const RecordedFrame& recorded) {
  if (recorded.flexible || recorded.length > Frame::kMaxBytes) return 0;
  Frame frame;
  frame.id = recorded.id;
  frame.dlc = recorded.length;
  std::copy_n(recorded.data, recorded.length, frame.data);
  return frame_bits(frame);
}

void take_value(SignalSurvey& out, const DbcSignal& signal, double value, std::size_t line) {
  if (!std::isfinite(value)) {
    ++out.not_finite;
    return;
  }
  out.min = out.count == 0 ? value : std::min(out.min, value);
  out.max = out.count == 0 ? value : std::max(out.max, value);
  out.sum += value;
  ++out.count;
  const bool below = signal.min && value < *signal.min - 1e-9 * std::abs(*signal.min);
  const bool above = signal.max && value > *signal.max + 1e-9 * std::abs(*signal.max);
  const bool stated = signal.min && signal.max && *signal.min < *signal.max;  // [0|0] states nothing
  if (stated && (below || above) && out.beyond_range++ == 0) out.first_beyond_line = line;
}

/// Takes frames into the survey of a recording.
class Surveyor {
 public:
  explicit Surveyor(const DbcSet& dbc)
      : dbc_(dbc), values_(dbc.most_signals()), present_(presence_words(dbc.most_signals())) {}

  void take(const RecordedFrame& frame) {
    FrameSurvey& survey = survey_of(frame);
    if (survey.count++ == 0) {
      survey.first_s = frame.time_s;
    } else {
      take_interval(survey, frame.time_s);
    }
    survey.last_s = frame.time_s;
    survey.length_min = std::min<unsigned>(survey.length_min, frame.length);
    survey.length_max = std::max<unsigned>(survey.length_max, frame.length);
    survey.flexible = survey.flexible || frame.flexible;
    survey.bits += bits_of(frame);
    survey.checksum.take(frame);
    if (survey.message != nullptr) take_signals(survey, frame);
  }

  void give(const std::vector<std::string>& buses, RecordingSurvey& out) {
    for (auto& [key, survey] : surveys_) out.frames[{buses.at(key.first), key.second}] = std::move(survey);
  }

 private:
  FrameSurvey& survey_of(const RecordedFrame& frame) {
    const std::pair<std::uint8_t, std::uint32_t> key{frame.bus, frame.id};
    const auto at = surveys_.find(key);
    if (at != surveys_.end()) return at->second;
    FrameSurvey& out = surveys_[key];
    out.message = dbc_.find(frame.id);
    if (out.message != nullptr) out.signals.resize(out.message->signals());
    return out;
  }

  static void take_interval(FrameSurvey& survey, double time_s) {
    const double interval_s = time_s - survey.last_s;
    survey.interval_sum_s += interval_s;
    survey.interval_square_sum += interval_s * interval_s;
    if (interval_s <= survey.longest_gap_s) return;
    survey.longest_gap_s = interval_s;
    survey.longest_gap_at_s = survey.last_s;
  }

  void take_signals(FrameSurvey& survey, const RecordedFrame& frame) {
    const DbcMessage& message = survey.message->message();
    if (frame.has_length && frame.length < message.length) ++survey.too_short;
    std::fill(present_.begin(), present_.end(), 0);
    survey.message->decode_all(frame, values_, present_);
    for (std::size_t k = 0; k < survey.signals.size(); ++k) {
      if ((present_[k / 64] >> (k % 64) & 1U) == 0) continue;
      const DbcSignal& signal = message.signals[k];
      if (!signal.invalid_codes.empty() && signal.is_invalid_code(signal.raw(frame.data))) {
        ++survey.signals[k].invalid;
      } else {
        take_value(survey.signals[k], signal, values_[k], frame.line);
      }
    }
  }

  const DbcSet& dbc_;
  std::vector<double> values_;
  std::vector<std::uint64_t> present_;
  std::map<std::pair<std::uint8_t, std::uint32_t>, FrameSurvey> surveys_;
};

}  // namespace

double FrameSurvey::interval_s() const {
  return count > 1 ? interval_sum_s / static_cast<double>(count - 1) : 0.0;
}

double FrameSurvey::jitter_s() const {
  if (count < 2) return 0.0;
  const double mean_s = interval_s();
  return std::sqrt(std::max(0.0, interval_square_sum / static_cast<double>(count - 1) - mean_s * mean_s));
}

bool FrameSurvey::has_gap() const {
  constexpr double kLeast_s = 0.5, kTimes = 10.0;
  return longest_gap_s > std::max(kLeast_s, kTimes * usual_interval_s());
}

double FrameSurvey::usual_interval_s() const {
  return count > 2 ? (interval_sum_s - longest_gap_s) / static_cast<double>(count - 2) : longest_gap_s;
}

double RecordingSurvey::load_pct(const std::string& bus, double bit_rate) const {
  VOLTLAP_DEMAND(bit_rate > 0.0);
  std::uint64_t bits = 0;
  for (const auto& [key, frame] : frames) bits += key.first == bus ? frame.bits : 0;
  return duration_s() > 0.0 ? 100.0 * static_cast<double>(bits) / (bit_rate * duration_s()) : 0.0;
}

RecordingSurvey survey(CanRecording& recording, const DbcSet& dbc, const std::function<void(std::size_t)>& progress) {
  Surveyor surveyor(dbc);
  RecordedFrame frame;
  for (std::size_t k = 1; recording.next(frame); ++k) {
    surveyor.take(frame);
    if (k % kOften == 0) progress(k);
  }
  RecordingSurvey out;
  out.summary = recording.summary();
  out.format = recording.format_name();
  surveyor.give(recording.buses(), out);
  return out;
}

}  // namespace voltlap::plant
