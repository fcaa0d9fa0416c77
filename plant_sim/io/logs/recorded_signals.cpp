// SPDX-License-Identifier: Apache-2.0
#include "io/logs/recorded_signals.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/dbc_file.hpp"
#include "io/logs/plain_columns.hpp"
#include "io/logs/signal_words.hpp"
#include "io/logs/wrapped_signal.hpp"

namespace voltlap::plant {
namespace {

bool has_numbers(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// "Volts", "%", and with a quantity before it as some exporters write: "torque:N.m".
std::optional<NamedUnit> unit_written(std::string_view text) {
  if (const auto unit = unit_named(text)) return unit;
  const std::size_t colon = text.rfind(':');
  return colon == std::string_view::npos ? std::nullopt : unit_named(text.substr(colon + 1));
}

/// "i_a" and "temp_c" end in their unit, "col_a" and "sensor_c" in a letter: the rest of the name must agree.
std::optional<NamedUnit> unit_of_letter(const std::string& column) {
  if (unit_named(column) && unit_named(column)->quantity == Quantity::kRotation)
    return unit_named(column);  // "rpm"
  if (column.ends_with("_pct")) return unit_named("%");
  const auto unit = unit_named(column_name(column).unit);
  if (!unit) return std::nullopt;
  const Meaning meaning = spoken_name(column).meaning;
  const bool is_t = meaning == Meaning::kTime && unit->quantity == Quantity::kTemperature;  // t1_c
  return is_t || is_of(unit->quantity, meaning) ? unit : std::nullopt;
}

/// One identifier on one bus, and the raw values of its signals.
struct FrameSamples {
  const DbcMessage* message;
  std::vector<std::vector<double>> time_s;
  std::vector<std::vector<std::uint64_t>> raw;
};

class SignalCollector {
 public:
  explicit SignalCollector(const std::vector<std::string>& dbc_files) {
    for (const std::string& file : dbc_files)
      files_.emplace_back(std::filesystem::absolute(file).lexically_normal());
    for (const DbcFile& file : files_) {
      for (const DbcMessage& message : file.messages()) messages_.try_emplace(message.id, &message);
    }
  }

  void take(const RecordedFrame& frame) {
    const auto at = messages_.find(frame.id);
    if (at == messages_.end()) return;
    const DbcMessage& message = *at->second;
    auto [entry, is_new] = heard_.try_emplace({frame.id, frame.bus});
    FrameSamples& samples = entry->second;
    if (is_new) samples = {&message, {}, {}};
    samples.time_s.resize(message.signals.size());
    samples.raw.resize(message.signals.size());
    for (std::size_t k = 0; k < message.signals.size(); ++k) {
      const DbcSignal& signal = message.signals[k];
      const auto raw = raw_value(message, signal, frame);
      if (!raw || signal.is_invalid_code(*raw) || signal.is_end_beyond_range(*raw)) continue;
      samples.time_s[k].push_back(frame.time_s);
      samples.raw[k].push_back(*raw);
    }
  }

  [[nodiscard]] std::vector<RecordedSignal> signals(const std::vector<std::string>& buses) const {
    std::map<std::uint32_t, int> buses_of;
    for (const auto& [key, samples] : heard_) ++buses_of[key.first];
    std::vector<RecordedSignal> out;
    for (const auto& [key, samples] : heard_) {
      for (std::size_t k = 0; k < samples.message->signals.size(); ++k) {
        if (samples.raw[k].empty()) continue;
        out.push_back(signal_of(samples, k));
        if (buses_of[key.first] > 1) out.back().source.bus = buses.at(key.second);
      }
    }
    return out;
  }

  [[nodiscard]] bool has_heard() const { return !heard_.empty(); }

 private:
  /// Exporters call signed signals unsigned; what wraps around zero gives itself away.
  static DbcSignal::Kind kind_of(const DbcSignal& signal, const std::vector<std::uint64_t>& raw) {
    if (signal.kind != DbcSignal::Kind::kUnsigned || signal.length < 8) return signal.kind;
    const auto verdict = wrapped_signal(raw, signal.length, [](std::uint64_t, bool) { return true; });
    return verdict.wrapping == Wrapping::kSigned ? DbcSignal::Kind::kSigned : signal.kind;
  }

  static RecordedSignal signal_of(const FrameSamples& samples, std::size_t k) {
    const DbcSignal& signal = samples.message->signals[k];
    RecordedSignal out;
    out.source.frame = samples.message->id;
    out.source.signal = signal.name;
    out.source.dbc = samples.message->file;
    out.label = signal.name;
    out.unit = unit_written(signal.unit);
    out.time_s = samples.time_s[k];
    out.value.reserve(out.time_s.size());
    const auto kind = kind_of(signal, samples.raw[k]);
    for (const std::uint64_t raw : samples.raw[k]) out.value.push_back(signal.value_as(kind, raw));
    VOLTLAP_DEMAND(out.value.size() == out.time_s.size());
    return out;
  }

  std::vector<DbcFile> files_;
  std::map<std::uint32_t, const DbcMessage*> messages_;
  std::map<std::pair<std::uint32_t, std::uint8_t>, FrameSamples> heard_;
};

}  // namespace

std::string RecordedSignal::described() const {
  if (!source.frame) return fmt::format("column \"{}\"", label);
  return fmt::format("{} {}{}", identifier_text(*source.frame), label,
                     source.bus.empty() ? "" : " on " + source.bus);
}

RecordedSignals signals_of(const MeasuredTable& table) {
  RecordedSignals out{table.path, false, {}};
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const bool unreadable = !table.about.empty() && !table.about[k].unreadable.empty();
    const bool repeated = table.find(table.columns[k]) != static_cast<int>(k);
    if (unreadable || repeated || !has_numbers(table.values[k])) continue;
    RecordedSignal signal;
    signal.source.column = signal.label = table.columns[k];
    signal.unit = file_unit(table, k);
    if (!signal.unit) signal.unit = unit_of_letter(table.columns[k]);
    signal.value = table.values[k];
    VOLTLAP_DEMAND(signal.value.size() == table.rows());
    out.signals.push_back(std::move(signal));
  }
  return out;
}

RecordedSignals signals_of(const std::string& can_recording, const std::vector<std::string>& dbc_files) {
  constexpr std::size_t kMostFrames = 1'000'000;
  VOLTLAP_DEMAND(!dbc_files.empty());
  SignalCollector collector(dbc_files);
  CanRecording recording(can_recording);
  RecordedFrame frame;
  for (std::size_t k = 0; k < kMostFrames && recording.next(frame); ++k) collector.take(frame);
  if (!collector.has_heard()) {
    throw InputError(can_recording, fmt::format("no frame of {}", fmt::join(dbc_files, ", ")),
                     "a DBC file of the bus that was recorded", "Give the file of that car with --dbc");
  }
  return {can_recording, true, collector.signals(recording.buses())};
}

}  // namespace voltlap::plant
