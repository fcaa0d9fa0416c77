// SPDX-License-Identifier: Apache-2.0
// Every signal of the frames that DBC files know.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/can/dbc_set.hpp"
#include "io/logs/plot/plotted_signals.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kToldEvery = 50'000;  // frames
constexpr std::size_t kNamed = 6;           // of a list in a note

/// Its values are named states, of which "Fault" and "Init" are as good as any: they are told, not left out.
bool is_state(const DbcSignal& signal) {
  const auto named = std::count_if(signal.value_names.begin(), signal.value_names.end(), [&](const auto& state) {
    return !signal.is_invalid_code(static_cast<std::uint64_t>(state.first) & signal.bits.mask());
  });
  return named >= 2;
}

/// Codes that a file says are no measurement, told by the raw value.
bool has_no_value_codes(const DbcSignal& signal) {
  if (is_state(signal)) return false;
  return !signal.invalid_codes.empty() || (signal.is_integer() && (signal.min || signal.max));
}

/// A frame of a DBC file on one bus, and the numbers of its signals.
struct HeardFrame {
  const CompiledMessage* message = nullptr;  ///< nullptr: no file knows it
  std::size_t first = 0;                     ///< number of its first signal
  std::size_t frames = 0;
  std::uint8_t bus = 0;
  std::vector<bool> has_codes;  ///< of each signal: raw values that are no measurement
};

/// Numbers of the signals by identifier and bus, in the order in which they were heard.
using HeardFrames = std::unordered_map<std::uint64_t, HeardFrame>;

class CanSignals : public PlottedSignals {
 public:
  CanSignals(const SignalSources& sources, const DataFolder& data);
  void read(const SampleSink& sink, const ReadProgress& progress) override;
  [[nodiscard]] const std::vector<SignalHead>& heads() const override { return heads_; }
  [[nodiscard]] std::vector<std::string> silent() const override;
  [[nodiscard]] const RecordingFacts& facts() const override { return facts_; }

 private:
  HeardFrame& heard(const RecordedFrame& frame, const std::vector<std::string>& buses);
  void give(const HeardFrame& heard, const RecordedFrame& frame, double time_s, const SampleSink& sink);
  void tell(const CanRecording& recording);
  void note_unknown();
  void note_refused();
  void name_by_bus(const std::vector<std::string>& buses);

  std::string path_;
  DbcSet dbc_;
  CanReading reading_{.broken = BrokenStream::kKeep, .period_s = {}};
  HeardFrames heard_;
  std::vector<SignalHead> heads_;
  std::vector<double> values_;
  std::vector<std::uint64_t> present_;
  RecordingFacts facts_;
  bool read_ = false;
};

CanSignals::CanSignals(const SignalSources& sources, const DataFolder& data)
    : path_(sources.recording), dbc_(sources.dbc_files) {
  values_.resize(dbc_.most_signals());
  present_.resize(presence_words(dbc_.most_signals()));
  if (!sources.map.empty()) {
    for (const auto& [role, source] : load_role_map(data.find("maps", sources.map, "--map")).roles) {
      if (source.frame && source.period_s) reading_.period_s[*source.frame] = *source.period_s;
    }
  }
  for (const auto& file : dbc_.files()) {
    for (const DbcMessage& message : file->messages()) {
      if (message.cycle_time_s) reading_.period_s.try_emplace(message.id, *message.cycle_time_s);
    }
  }
}

HeardFrame& CanSignals::heard(const RecordedFrame& frame, const std::vector<std::string>& buses) {
  const std::uint64_t key = (static_cast<std::uint64_t>(frame.bus) << 32U) | frame.id;
  const auto [at, is_new] = heard_.try_emplace(key);
  if (!is_new) return at->second;
  HeardFrame& out = at->second;
  out.bus = frame.bus;
  out.message = dbc_.find(frame.id);
  if (out.message == nullptr) return out;
  out.first = heads_.size();
  const DbcMessage& message = out.message->message();
  const std::string bus = frame.bus < buses.size() ? ", " + buses[frame.bus] : std::string();
  for (const DbcSignal& signal : message.signals) {
    SignalHead head{message.name + "." + signal.name, signal.unit, identifier_text(message.id) + bus, {}};
    for (const auto& [raw, name] : signal.value_names)
      head.states[static_cast<double>(raw) * signal.scale + signal.offset] = name;
    heads_.push_back(std::move(head));
    out.has_codes.push_back(has_no_value_codes(signal));
  }
  return out;
}

void CanSignals::give(const HeardFrame& heard, const RecordedFrame& frame, double time_s, const SampleSink& sink) {
  heard.message->decode_all(frame, values_, present_);
  const std::vector<DbcSignal>& signals = heard.message->message().signals;
  VOLTLAP_DEMAND(heard.first + signals.size() <= heads_.size() && heard.has_codes.size() == signals.size());
  for (std::size_t k = 0; k < signals.size(); ++k) {
    if ((present_[k / 64] >> (k % 64) & 1U) == 0) continue;
    double value = values_[k];
    if (heard.has_codes[k]) {
      const std::uint64_t raw = signals[k].raw(frame.data);
      if (signals[k].is_invalid_code(raw) || signals[k].is_end_beyond_range(raw)) value = kNoValue;
    }
    sink(heard.first + k, time_s, value);
  }
}

void CanSignals::read(const SampleSink& sink, const ReadProgress& progress) {
  CanRecording recording(path_, reading_);
  for (auto& [key, frame] : heard_) frame.frames = 0;
  RecordedFrame frame;
  std::size_t frames = 0;
  while (recording.next(frame)) {
    if (++frames % kToldEvery == 0) progress(frames);
    HeardFrame& heard = this->heard(frame, recording.buses());
    ++heard.frames;
    if (heard.message != nullptr) give(heard, frame, frame.time_s - recording.summary().begin_s, sink);
  }
  if (!read_) tell(recording);
  read_ = true;
}

/// What a Vector ASC file says in its first lines of when it began: "date Sat Nov 1 06:12:33.123 pm 2025".
std::string asc_start(const std::string& path) {
  constexpr std::size_t kHeader = 10;
  LineReader lines(path, "a CAN recording", BrokenStream::kKeep);
  std::string_view line;
  while (lines.number() < kHeader && lines.next(line)) {
    if (line.starts_with("date ")) return std::string(line.substr(5)) + ", clock of the recorder";
  }
  return {};
}

/// After the first reading.
void CanSignals::tell(const CanRecording& recording) {
  const CanSummary& summary = recording.summary();
  facts_.format = fmt::format("{}{}", recording.format_name(),
                              summary.buses.size() > 1 ? fmt::format(", {} buses", summary.buses.size()) : "");
  facts_.start = start_text(summary.begin_s);
  if (facts_.start.empty() && recording.format() == CanFormat::kAsc) facts_.start = asc_start(path_);
  facts_.duration_s = summary.end_s - summary.begin_s;
  facts_.frames = summary.frames;
  for (const CanDefect& defect : summary.defects) {
    const std::string place =
        defect.first_line > 0 ? fmt::format(", first in line {}", defect.first_line) : std::string();
    facts_.notes.push_back(
        fmt::format("{} x {}{}{}", defect.count, defect.kind, defect.used ? ": mended" : ": left out", place));
  }
  for (const std::string& note : summary.notes) facts_.notes.push_back(note);
  if (!summary.broken.empty()) facts_.notes.push_back("the recording ends early: " + summary.broken);
  note_refused();
  note_unknown();
  name_by_bus(summary.buses);
  if (!heads_.empty()) return;
  throw InputError(path_, fmt::format("{} frames, none with an identifier of the DBC files", summary.frames),
                   "frames that they describe", "Check that recording and --dbc belong together");
}

/// Frames that no file knows, most frequent first.
void CanSignals::note_unknown() {
  std::map<std::uint32_t, std::size_t> counts;
  std::size_t frames = 0;
  for (const auto& [key, heard] : heard_) {
    if (heard.message != nullptr || dbc_.refusal(static_cast<std::uint32_t>(key)) != nullptr) continue;
    counts[static_cast<std::uint32_t>(key)] += heard.frames;
    frames += heard.frames;
  }
  if (counts.empty()) return;
  std::vector<std::pair<std::uint32_t, std::size_t>> sorted(counts.begin(), counts.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  sorted.resize(std::min(sorted.size(), kNamed));
  std::vector<std::string> named;
  for (const auto& [id, count] : sorted) named.push_back(fmt::format("{} ({})", identifier_text(id), count));
  facts_.notes.push_back(fmt::format("{} frames of {} identifiers stand in no DBC file and are not shown: {}{}", frames,
                                     counts.size(), fmt::join(named, ", "), counts.size() > kNamed ? " ..." : ""));
}

/// Frames that a file has and that cannot be decoded as it describes them.
void CanSignals::note_refused() {
  std::map<std::uint32_t, std::size_t> counts;
  for (const auto& [key, heard] : heard_) {
    if (heard.message == nullptr) counts[static_cast<std::uint32_t>(key)] += heard.frames;
  }
  for (const auto& [id, count] : counts) {
    const DbcRefusal* refused = dbc_.refusal(id);
    if (refused == nullptr) continue;
    facts_.notes.push_back(fmt::format("{} frames {} {} are not shown: line {} of the DBC file has {}; expected {}",
                                       count, identifier_text(id), refused->name, refused->line, refused->found,
                                       refused->expected));
  }
}

/// Where several buses have the same frame, its signals are told apart by the bus.
void CanSignals::name_by_bus(const std::vector<std::string>& buses) {
  std::map<std::uint32_t, std::size_t> buses_of;
  for (const auto& [key, heard] : heard_) ++buses_of[static_cast<std::uint32_t>(key)];
  for (const auto& [key, heard] : heard_) {
    if (heard.message == nullptr || buses_of[static_cast<std::uint32_t>(key)] < 2) continue;
    for (std::size_t k = 0; k < heard.message->signals(); ++k) {
      std::string& name = heads_[heard.first + k].name;
      name = (heard.bus < buses.size() ? buses[heard.bus] : std::to_string(heard.bus)) + ":" + name;
    }
  }
}

std::vector<std::string> CanSignals::silent() const {
  std::map<std::string, bool> is_heard;
  for (const auto& [key, heard] : heard_) {
    if (heard.message != nullptr) is_heard[heard.message->message().name] = true;
  }
  std::vector<std::string> out;
  for (const auto& file : dbc_.files()) {
    for (const DbcMessage& message : file->messages()) {
      if (is_heard.contains(message.name)) continue;
      for (const DbcSignal& signal : message.signals) out.push_back(message.name + "." + signal.name);
    }
  }
  return out;
}

}  // namespace

std::unique_ptr<PlottedSignals> can_signals(const SignalSources& sources, const DataFolder& data) {
  return std::make_unique<CanSignals>(sources, data);
}

}  // namespace voltlap::plant
