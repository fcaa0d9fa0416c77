// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array kFormats{CanFormat::kCandump, CanFormat::kAsc, CanFormat::kRawHex, CanFormat::kSlcan};
constexpr std::size_t kFirstLines = 1000;
constexpr double kFarAhead = 10.0;                      // s
constexpr double kSlcanTurn = 60.0, kSlcanHalf = 30.0;  // s; the stamp starts again each minute

/// A file may begin with anything; the format in which most of its first lines are frames is its own.
std::optional<CanFormat> format_of(const std::string& path) {
  std::array<std::size_t, kFormats.size()> frames{};
  std::array<CanLineState, kFormats.size()> states{};
  LineReader reader(path);
  std::string_view line;
  TimedFrame ignored;
  while (reader.number() < kFirstLines && reader.next(line)) {
    for (std::size_t k = 0; k < kFormats.size(); ++k) {
      frames[k] += parse_can_line(kFormats[k], line, states[k], ignored) == CanLine::kFrame ? 1U : 0U;
    }
  }
  const auto best = std::max_element(frames.begin(), frames.end());
  if (*best == 0) return std::nullopt;
  return kFormats[static_cast<std::size_t>(best - frames.begin())];
}

CanFormat known_format(const std::string& path) {
  if (const auto format = format_of(path)) return *format;
  throw InputError(path, "no frame in the first 1000 lines",
                   "a CAN recording: candump -l, Vector ASC, raw hex (ms x id data) or SLCAN, plain or gzipped",
                   "Convert the recording to one of these");
}

const char* kind_of(CanLine line) {
  switch (line) {
    case CanLine::kFlexible:
      return "CAN FD frame, not read";
    case CanLine::kRemote:
      return "remote frame, without data";
    case CanLine::kError:
      return "error frame";
    case CanLine::kBeyondBus:
      return "identifier beyond 29 bits";
    case CanLine::kEmptySlot:
      return "empty slot";
    default:
      return "line that is no frame";
  }
}

}  // namespace

CanRecording::CanRecording(const std::string& path) : reader_(path), format_(known_format(path)) {}

void CanRecording::count(const char* kind, std::size_t line, double time_s) {
  auto at = std::find_if(summary_.defects.begin(), summary_.defects.end(),
                         [&](const CanDefect& defect) { return defect.kind == kind; });
  if (at == summary_.defects.end()) {
    at = summary_.defects.insert(at, {kind, 0, line, time_s, time_s});
  }
  ++at->count;
  at->last_s = time_s;
}

void CanRecording::judge_lines() const {
  if (reader_.number() > kFirstLines || 2 * unreadable_ <= kFirstLines) return;
  throw InputError(reader_.place(), fmt::format("{} lines that are no frames", unreadable_),
                   fmt::format("a recording in the format {}, as its other lines are", name_of(format_)),
                   "Check that the file is whole and of one format");
}

void CanRecording::absolute_time(TimedFrame& frame) {
  if (format_ == CanFormat::kAsc && state_.relative) {
    last_s_ += frame.time_s;
    frame.time_s = last_s_;
  }
  if (format_ != CanFormat::kSlcan) return;
  if (frame.time_s < last_s_ - kSlcanHalf) turns_s_ += kSlcanTurn;
  last_s_ = frame.time_s;
  frame.time_s += turns_s_;
}

bool CanRecording::read(TimedFrame& out) {
  std::string_view line;
  while (reader_.next(line)) {
    ++summary_.lines;
    const CanLine kind = parse_can_line(format_, line, state_, out);
    if (kind == CanLine::kHeader) continue;
    if (kind == CanLine::kFrame) {
      absolute_time(out);
      out.line = reader_.number();
      return true;
    }
    if (kind == CanLine::kUnreadable) ++unreadable_;
    count(kind_of(kind), reader_.number(), summary_.end_s);
    judge_lines();
  }
  return false;
}

bool CanRecording::next(TimedFrame& out) {
  TimedFrame frame;
  while (read(frame)) {
    const bool first = summary_.frames == 0;
    if (!pending_) {
      pending_ = frame;
      continue;
    }
    if (!first && pending_->time_s < summary_.end_s) {
      count("time goes back", pending_->line, pending_->time_s);
      pending_ = frame;
      continue;
    }
    const bool alone = frame.time_s < pending_->time_s - kFarAhead && (first || frame.time_s >= summary_.end_s);
    if (alone) {
      count("time far ahead of the frames around it", pending_->line, pending_->time_s);
      pending_ = frame;
      continue;
    }
    out = std::exchange(*pending_, frame);
    give(out);
    return true;
  }
  if (!pending_) return false;
  out = *pending_;
  pending_.reset();
  if (summary_.frames > 0 && out.time_s < summary_.end_s) {
    count("time goes back", out.line, out.time_s);
    return false;
  }
  give(out);
  return true;
}

void CanRecording::give(const TimedFrame& frame) {
  VOLTLAP_DEMAND(summary_.frames == 0 || !(frame.time_s < summary_.end_s));
  VOLTLAP_DEMAND(frame.frame.dlc <= Frame::kMaxBytes);
  if (summary_.frames++ == 0) summary_.begin_s = frame.time_s;
  summary_.end_s = frame.time_s;
}

bool is_can_recording(const std::string& path) {
  return format_of(path).has_value();
}

}  // namespace voltlap::plant
