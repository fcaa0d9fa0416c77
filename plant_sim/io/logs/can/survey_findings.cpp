// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/survey_findings.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kAbsolute = 1e8;  // s; a time beyond counts from 1970

std::string frame_name(const std::string& bus, std::uint32_t id, const FrameSurvey& frame) {
  const std::string name = frame.message == nullptr ? "" : " " + frame.message->message().name;
  return fmt::format("{} {}{}", bus, identifier_text(id), name);
}

void add_summary(const CanSummary& summary, std::vector<Finding>& out) {
  for (const CanDefect& defect : summary.defects) {
    out.push_back({defect.kind, "", defect.count,
                   fmt::format("{} x {}, {}{}", defect.count, defect.kind, defect.used ? "used" : "left out",
                               defect.first_line > 0 ? fmt::format(", first in line {}", defect.first_line) : "")});
  }
  for (const ClockPart& part : summary.parts) {
    if (part.begin == ClockPart::Begin::kFirst) continue;
    const bool anew = part.begin == ClockPart::Begin::kAnew;
    out.push_back({anew ? "clock starts anew" : "clock set", "", 1,
                   fmt::format("the clock {} in line {}; the parts are joined", anew ? "starts anew" : "was set",
                               part.first_line)});
  }
  if (!summary.broken.empty()) {
    out.push_back({"file breaks off", "", 1, summary.broken + "; what stands before it is used"});
  }
}

void add_frame(const std::string& name, const FrameSurvey& frame, double begin_s, std::vector<Finding>& out) {
  if (frame.has_gap()) {
    out.push_back({"gap", name, 1,
                   fmt::format("{}: silent for {:.3f} s from {:.3f} s on; usual are {:.1f} ms", name,
                               frame.longest_gap_s, frame.longest_gap_at_s - begin_s, 1e3 * frame.usual_interval_s())});
  }
  if (frame.too_short > 0) {
    out.push_back({"frame too short", name, frame.too_short,
                   fmt::format("{}: {} of {} frames have fewer than the {} bytes of the DBC", name, frame.too_short,
                               frame.count, frame.message->message().length)});
  }
  if (const auto checksum = frame.checksum.found(); checksum && checksum->breaks > 0) {
    out.push_back({"checksum does not hold", name, checksum->breaks,
                   fmt::format("{}: {} of {} frames break the checksum of the others, {}, first in line {}", name,
                               checksum->breaks, frame.count, checksum->rule, checksum->first_break_line)});
  }
  for (std::size_t k = 0; k < frame.signals.size(); ++k) {
    const SignalSurvey& signal = frame.signals[k];
    const DbcSignal& said = frame.message->message().signals[k];
    const std::string where = name + "." + said.name;
    if (signal.beyond_range > 0) {
      out.push_back({"value out of range", where, signal.beyond_range,
                     fmt::format("{}: {} of {} values outside {:g} to {:g} {} of the DBC ({:g} to {:g}), first in "
                                 "line {}",
                                 where, signal.beyond_range, signal.count, said.min.value_or(0.0),
                                 said.max.value_or(0.0), said.unit, signal.min, signal.max, signal.first_beyond_line)});
    }
    if (signal.not_finite > 0) {
      out.push_back({"no number", where, signal.not_finite,
                     fmt::format("{}: {} values are no number", where, signal.not_finite)});
    }
  }
}

std::string time_text(double time_s) {
  if (time_s < kAbsolute) return fmt::format("{:.3f} s", time_s);
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(time_s)));
}

void append_frames(const RecordingSurvey& survey, std::string& out) {
  out += fmt::format("\n  {:10} {:10} {:28} {:>9} {:>11} {:>10} {:>12}  bytes\n", "bus", "identifier", "frame",
                     "frames", "every", "+- rms", "longest gap");
  for (const auto& [key, frame] : survey.frames) {
    const bool one_length = frame.length_min == frame.length_max;
    out += fmt::format("  {:10} {:10} {:28} {:>9} {:>8.1f} ms {:>7.1f} ms {:>10.3f} s  {}{}\n", key.first,
                       identifier_text(key.second), frame.message == nullptr ? "" : frame.message->message().name,
                       frame.count, 1e3 * frame.interval_s(), 1e3 * frame.jitter_s(), frame.longest_gap_s,
                       one_length ? fmt::format("{}", frame.length_max)
                                  : fmt::format("{} to {}", frame.length_min, frame.length_max),
                       frame.flexible ? " FD" : "");
  }
}

void append_signals(const RecordingSurvey& survey, std::string& out) {
  bool headed = false;
  for (const auto& [key, frame] : survey.frames) {
    if (frame.message == nullptr) continue;
    for (std::size_t k = 0; k < frame.signals.size(); ++k) {
      const SignalSurvey& signal = frame.signals[k];
      const DbcSignal& said = frame.message->message().signals[k];
      if (!headed) {
        out += fmt::format("\n  {:58} {:>12} {:>12} {:>12} {:8} {:>9}\n", "signal", "lowest", "mean", "highest",
                           "unit", "values");
      }
      headed = true;
      const std::string name = frame.message->message().name + "." + said.name;
      if (signal.count == 0) {
        out += fmt::format("  {:58} {:>12} {:>12} {:>12} {:8} {:>9}{}\n", name, "", "", "", said.unit, 0,
                           signal.invalid > 0 ? fmt::format("  {} say \"no value\"", signal.invalid) : "");
        continue;
      }
      out += fmt::format("  {:58} {:>12.6g} {:>12.6g} {:>12.6g} {:8} {:>9}\n", name, signal.min, signal.mean(),
                         signal.max, said.unit, signal.count);
    }
  }
}

nlohmann::ordered_json signals_json(const FrameSurvey& frame) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < frame.signals.size(); ++k) {
    const SignalSurvey& signal = frame.signals[k];
    const DbcSignal& said = frame.message->message().signals[k];
    nlohmann::ordered_json entry{{"name", said.name}, {"unit", said.unit}, {"values", signal.count}};
    if (signal.count > 0) {
      entry["min"] = signal.min;
      entry["mean"] = signal.mean();
      entry["max"] = signal.max;
    }
    entry["invalid"] = signal.invalid;
    entry["out_of_range"] = signal.beyond_range;
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace

std::vector<Finding> findings(const RecordingSurvey& survey, const DbcSet& dbc) {
  std::vector<Finding> out;
  add_summary(survey.summary, out);
  for (const auto& [key, frame] : survey.frames) {
    const std::string name = frame_name(key.first, key.second, frame);
    add_frame(name, frame, survey.summary.begin_s, out);
    if (const DbcRefusal* refusal = dbc.refusal(key.second)) {
      out.push_back({"frame refused in the DBC", name, frame.count,
                     fmt::format("{}: {} frames are not decoded: the DBC has {} in line {}, expected {}", name,
                                 frame.count, refusal->found, refusal->line, refusal->expected)});
    }
  }
  return out;
}

std::string account_text(const CanSummary& summary) {
  std::size_t refused = 0;
  std::string kinds;
  for (const CanDefect& defect : summary.defects) {
    if (defect.used) continue;
    refused += defect.count;
    kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", defect.count, defect.kind);
  }
  VOLTLAP_DEMAND(summary.frames + refused == summary.frames_in_file);
  return fmt::format("{} frames in the file = {} used + {} left out{}", summary.frames_in_file, summary.frames, refused,
                     kinds.empty() ? "" : " (" + kinds + ")");
}

std::string dbc_faults_text(const DbcSet& dbc) {
  constexpr std::size_t kMost = 100;
  std::vector<std::string> lines;
  for (const auto& file : dbc.files()) {
    for (const DbcRefusal& refusal : file->refused()) {
      lines.push_back(fmt::format("    {}:{}: {} {} is not decoded: {}; expected {}\n", file->path(), refusal.line,
                                  identifier_text(refusal.id), refusal.name, refusal.found, refusal.expected));
    }
    for (const DbcNote& note : file->notes()) {
      lines.push_back(fmt::format("    {}:{}: {}\n", file->path(), note.line, note.text));
    }
  }
  std::string out = lines.empty() ? "" : "  faults of the DBC files\n";
  for (std::size_t k = 0; k < std::min(kMost, lines.size()); ++k) out += lines[k];
  if (lines.size() > kMost) out += fmt::format("    and {} more\n", lines.size() - kMost);
  return out;
}

std::string checksum_text(const RecordingSurvey& survey) {
  std::string out;
  for (const auto& [key, frame] : survey.frames) {
    const auto found = frame.checksum.found();
    if (!found) continue;
    if (out.empty()) out = "  last byte a checksum, by the frames themselves\n";
    out += fmt::format("    {}: {}; holds in {} frames, breaks in {}\n", frame_name(key.first, key.second, frame),
                       found->rule, found->holds, found->breaks);
  }
  return out;
}

std::string survey_text(const std::string& path, const RecordingSurvey& survey, double bit_rate) {
  const CanSummary& summary = survey.summary;
  std::string out = fmt::format("{}: {}, {:.3f} s, {} to {}\n  {}\n", path, survey.format, survey.duration_s(),
                                time_text(summary.begin_s), time_text(summary.end_s), account_text(summary));
  for (const std::string& note : summary.notes) out += fmt::format("  {}\n", note);
  for (const std::string& bus : summary.buses) {
    out += fmt::format("  {}: {:.1f} % of {:g} kbit/s\n", bus, survey.load_pct(bus, bit_rate), 1e-3 * bit_rate);
  }
  append_frames(survey, out);
  append_signals(survey, out);
  return out;
}

std::string survey_json(const std::string& path, const RecordingSurvey& survey, const DbcSet& dbc, double bit_rate) {
  using Json = nlohmann::ordered_json;
  const CanSummary& summary = survey.summary;
  Json out{{"recording", path},
           {"format", survey.format},
           {"begin_s", summary.begin_s},
           {"end_s", summary.end_s},
           {"frames_in_file", summary.frames_in_file},
           {"frames_used", summary.frames},
           {"frames_left_out", Json::object()},
           {"frames_mended", Json::object()},
           {"broken", summary.broken},
           {"notes", summary.notes},
           {"buses", Json::array()},
           {"frames", Json::array()},
           {"findings", Json::array()}};
  for (const CanDefect& defect : summary.defects) {
    out[defect.used ? "frames_mended" : "frames_left_out"][defect.kind] = defect.count;
  }
  for (const std::string& bus : summary.buses) {
    out["buses"].push_back({{"name", bus}, {"load_pct", survey.load_pct(bus, bit_rate)}, {"bit_rate", bit_rate}});
  }
  for (const auto& [key, frame] : survey.frames) {
    Json entry{{"bus", key.first},
               {"id", key.second & ~RecordedFrame::kExtendedFlag},
               {"extended", (key.second & RecordedFrame::kExtendedFlag) != 0},
               {"name", frame.message == nullptr ? "" : frame.message->message().name},
               {"count", frame.count},
               {"interval_s", frame.interval_s()},
               {"jitter_s", frame.jitter_s()},
               {"longest_gap_s", frame.longest_gap_s},
               {"length_min", frame.length_min},
               {"length_max", frame.length_max},
               {"flexible", frame.flexible}};
    if (const auto found = frame.checksum.found()) {
      entry["checksum"] = {{"rule", found->rule}, {"holds", found->holds}, {"breaks", found->breaks}};
    }
    if (frame.message != nullptr) entry["signals"] = signals_json(frame);
    out["frames"].push_back(std::move(entry));
  }
  for (const Finding& finding : findings(survey, dbc)) {
    out["findings"].push_back(
        {{"kind", finding.kind}, {"where", finding.where}, {"count", finding.count}, {"text", finding.text}});
  }
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace voltlap::plant
