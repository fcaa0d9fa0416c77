// SPDX-License-Identifier: Apache-2.0
#include "io/logs/signal_tap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/isolated_code.hpp"
#include "io/logs/wrapped_signal.hpp"

namespace voltlap::plant {
namespace {

using Kind = DbcSignal::Kind;

constexpr long kMostNumbers = 1000;
constexpr unsigned kShortestCode = 8;  // bits: shorter signals use every value

bool may_be_negative(std::string_view role) {
  return role == "current" || role == "charge_ah" || role == "speed" || role == "ambient" || role == "motor_speed" ||
         role == "motor_torque" || role == "motor_current" ||
         role.starts_with("wheel_speed_") || role.starts_with("temperature_");
}

/// Whether the DBC's range allows a value. Read as signed, a minimum of 0 or more says nothing: it follows from the
/// sign that is in doubt; what is below 0 may be as large as what is above.
bool is_in_range(const DbcSignal& signal, double recorded, bool is_signed) {
  if (!signal.min || !signal.max || !(*signal.min < *signal.max)) return true;
  const double tolerance = 0.5 * std::abs(signal.scale);
  const double min = is_signed && *signal.min >= 0.0 ? -*signal.max : *signal.min;
  return recorded >= min - tolerance && recorded <= *signal.max + tolerance;
}

/// Whether a value is one that the role, the map and the DBC's range allow.
bool is_possible(const DbcSignal& signal, const RoleSource& source, std::string_view role, double recorded,
                 bool is_signed) {
  if (!is_in_range(signal, recorded, is_signed)) return false;
  const RoleRange range = role_range(role);
  const double lowest = may_be_negative(role) ? range.min : std::max(range.min, 0.0);
  const double value = recorded * source.scale + source.offset;
  return value >= source.min.value_or(lowest) && value <= source.max.value_or(range.max);
}

}  // namespace

void SignalSamples::add(double time_s, std::uint64_t raw) {
  time_s_.push_back(time_s);
  raw_.push_back(raw);
}

void SignalSamples::mask(double time_s, const char* reason) {
  masked_.emplace_back(time_s_.size(), reason);
  add(time_s, 0);
}

void SignalSamples::add_lost_frames(double from_s, double to_s, std::size_t frames) {
  lost_.push_back({time_s_.size(), from_s, to_s, frames});
}

std::vector<std::uint64_t> SignalSamples::raw_values(const DbcSignal& signal) const {
  std::vector<std::uint64_t> out;
  out.reserve(raw_.size());
  auto masked = masked_.begin();
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    if (masked != masked_.end() && masked->first == k) {
      ++masked;
    } else if (!signal.is_invalid_code(raw_[k])) {
      out.push_back(raw_[k]);
    }
  }
  VOLTLAP_DEMAND(masked == masked_.end());
  return out;
}

void SignalSamples::give(ChannelBuilder& builder, const DbcSignal& signal, Kind kind,
                         const std::map<std::uint64_t, const char*>& no_values) const {
  VOLTLAP_DEMAND(time_s_.size() == raw_.size());
  auto masked = masked_.begin();
  auto lost = lost_.begin();
  const auto give_lost = [&](std::size_t before) {
    for (; lost != lost_.end() && lost->before <= before; ++lost) {
      builder.add_lost_frames(lost->from_s, lost->to_s, lost->frames);
    }
  };
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    give_lost(k);
    if (masked != masked_.end() && masked->first == k) {
      builder.mask(time_s_[k], (masked++)->second);
    } else if (signal.is_invalid_code(raw_[k])) {
      builder.mask(time_s_[k], "invalid code");
    } else if (const auto code = no_values.find(raw_[k]); code != no_values.end()) {
      builder.mask(time_s_[k], code->second);
    } else {
      builder.add(time_s_[k], signal.value_as(kind, raw_[k]));
    }
  }
  give_lost(raw_.size());
}

SignalTap::SignalTap(DriveLog& log, const std::string& role, const RoleSource& source, const DbcMessage& message,
                     const DbcSignal& signal, const DbcSignal* index)
    : log_(log), role_(role), source_(source), message_(message), signal_(signal), index_(index) {
  if (index_ == nullptr) samples_[0];
}

void SignalTap::take(double time_s, const RecordedFrame& frame) {
  const auto raw = raw_value(message_, signal_, frame);
  if (!raw) {
    const bool is_short = frame.has_length && signal_.bytes() > frame.length;
    if (is_short && index_ == nullptr) samples_.at(0).mask(time_s, "frame too short for the signal");
    return;
  }
  if (SignalSamples* samples = samples_for(frame)) samples->add(time_s, *raw);
}

void SignalTap::mask(double time_s, const RecordedFrame& frame, const char* reason) {
  if (!raw_value(message_, signal_, frame)) return;
  // An index in a frame that cannot be trusted tells nothing.
  if (index_ == nullptr) samples_.at(0).mask(time_s, reason);
}

void SignalTap::add_lost_frames(double from_s, double to_s, std::size_t frames) {
  if (index_ == nullptr) samples_.at(0).add_lost_frames(from_s, to_s, frames);
}

SignalSamples* SignalTap::samples_for(const RecordedFrame& frame) {
  if (index_ == nullptr) return &samples_.at(0);
  const auto raw = raw_value(message_, *index_, frame);
  if (!raw) return nullptr;
  const double number = index_->value(*raw);
  if (!(std::abs(number) <= kMostNumbers)) return nullptr;
  const long n = static_cast<long>(number) - source_.first.value_or(0) + 1;
  if (n < 1 || n > kMostNumbers) return nullptr;
  return &samples_[n];
}

std::string SignalTap::channel_of(long n) const {
  return n > 0 ? with_number(role_, n) : role_;
}

std::vector<std::string> SignalTap::channels() const {
  std::vector<std::string> out;
  for (const auto& [n, samples] : samples_) out.push_back(channel_of(n));
  return out;
}

void SignalTap::finish() {
  for (auto& [n, samples] : samples_) {
    finish(n, samples);
    samples = {};  // the channel has them now
  }
}

void SignalTap::finish(long n, const SignalSamples& samples) {
  const std::string channel = channel_of(n);
  ChannelBuilder builder(log_, channel, source_, fmt::format("{} {}", identifier_text(message_.id), signal_.name));
  std::vector<std::uint64_t> raw;
  if (signal_.is_integer()) raw = samples.raw_values(signal_);
  const Kind kind = kind_in(raw, channel);
  samples.give(builder, signal_, kind, no_values(raw, kind));
  builder.finish();
}

/// As the DBC says, unless the values show that it is wrong.
Kind SignalTap::kind_in(const std::vector<std::uint64_t>& raw, const std::string& channel) {
  // Two's complement counts from zero: a signal with an offset does not need it.
  if (signal_.kind != Kind::kUnsigned || signal_.offset != 0.0) return signal_.kind;
  const auto value = [&](std::uint64_t number, bool is_signed) {
    return signal_.value_as(is_signed ? Kind::kSigned : Kind::kUnsigned, number);
  };
  const WrapVerdict verdict = wrapped_signal(raw, signal_.length, [&](std::uint64_t number, bool is_signed) {
    return is_possible(signal_, source_, channel, value(number, is_signed), is_signed);
  });
  if (verdict.wrapping == Wrapping::kNone) return signal_.kind;
  const std::string place =
      signal_.line > 0 ? fmt::format("{}:{}", message_.file, signal_.line) : message_.file;
  if (verdict.wrapping == Wrapping::kDoubtful) {
    throw InputError(place,
                     fmt::format("signal {}, declared unsigned, whose values jump {} times between the ends of its "
                                 "range: up to {:g} {} as it stands, down to {:g} {} if it is signed",
                                 signal_.name, verdict.crossings, value(verdict.largest, false), signal_.unit,
                                 value(verdict.lowest, true), signal_.unit),
                     "a range [min|max] that leaves only one of them",
                     fmt::format("Correct the sign or the range in the DBC, or give min or max of roles.{} in the map",
                                 role_));
  }
  log_.defects.push_back(
      {"declared unsigned, wraps as signed", channel, verdict.negative, 0.0,
       fmt::format("{} ({} {}): declared unsigned, but its values wrap around 0 as a signed one does: read as signed "
                   "({} of {} samples are below 0); correct the DBC ({})",
                   channel, identifier_text(message_.id), signal_.name, verdict.negative, raw.size(), place)});
  return Kind::kSigned;
}

/// Ends of the raw range that are no measurement although no table of values says so, each with its reason.
std::map<std::uint64_t, const char*> SignalTap::no_values(const std::vector<std::uint64_t>& raw, Kind kind) const {
  std::map<std::uint64_t, const char*> out;
  if (!signal_.is_integer() || signal_.length < kShortestCode) return out;
  const std::uint64_t ones = signal_.bits.mask();
  const bool is_signed = kind == Kind::kSigned;
  std::vector<double> values;
  for (const std::uint64_t code : is_signed ? std::vector{ones >> 1, (ones >> 1) + 1} : std::vector{ones}) {
    if (std::find(raw.begin(), raw.end(), code) == raw.end()) continue;
    if (signal_.is_end_beyond_range(kind, code)) {
      out[code] = is_signed ? "end of the raw values, taken as no value: beyond the DBC's range"
                            : "all ones, taken as no value: beyond the DBC's range";
      continue;
    }
    if (values.empty()) {
      for (const std::uint64_t number : raw) values.push_back(signal_.value_as(kind, number));
    }
    if (all_ones_is_no_value(values, signal_.value_as(kind, code))) {
      out[code] = is_signed ? "end of the raw values, taken as no value: there for moments only"
                            : "all ones, taken as no value: there for moments only";
    }
  }
  return out;
}

}  // namespace voltlap::plant
