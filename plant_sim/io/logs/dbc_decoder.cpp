// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_decoder.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

/// What signals of one group have in common.
using GroupKey = std::pair<std::size_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>>;

GroupKey key_of(const DbcSignal& signal) {
  GroupKey out{signal.multiplexer ? *signal.multiplexer + 1 : 0, {}};
  for (const RawRange& range : signal.cases) out.second.emplace_back(range.first, range.last);
  return out;
}

}  // namespace

/// How many multiplexers stand above each signal.
std::vector<std::uint32_t> CompiledMessage::depths() const {
  std::vector<std::uint32_t> out;
  for (const DbcSignal& signal : message_->signals) {
    std::uint32_t depth = 0;
    for (const DbcSignal* below = &signal; below->multiplexer; below = &message_->signals[*below->multiplexer]) {
      VOLTLAP_DEMAND(++depth <= message_->signals.size());  // dbc_json.py refuses circles
    }
    out.push_back(depth);
  }
  return out;
}

CompiledMessage::CompiledMessage(const DbcMessage& message) : message_(&message) {
  const std::vector<std::uint32_t> depth = depths();
  std::map<std::pair<std::uint32_t, GroupKey>, std::vector<std::uint32_t>> by_case;
  for (std::uint32_t k = 0; k < message.signals.size(); ++k) {
    by_case[{depth[k], key_of(message.signals[k])}].push_back(k);
  }
  for (const auto& [key, numbers] : by_case) add_group(numbers);
  VOLTLAP_DEMAND(fields_.size() == message.signals.size());
}

void CompiledMessage::add_group(const std::vector<std::uint32_t>& numbers) {
  VOLTLAP_DEMAND(!numbers.empty());
  const DbcSignal& any = message_->signals[numbers.front()];
  Group group{static_cast<std::uint32_t>(fields_.size()),
              static_cast<std::uint32_t>(numbers.size()),
              kNone,
              static_cast<std::uint32_t>(cases_.size()),
              static_cast<std::uint32_t>(any.cases.size()),
              {},
              0};
  if (any.multiplexer) {
    group.multiplexer = static_cast<std::uint32_t>(*any.multiplexer);
    group.selector = message_->signals[*any.multiplexer].bits;
    cases_.insert(cases_.end(), any.cases.begin(), any.cases.end());
  }
  for (const std::uint32_t number : numbers) {
    const DbcSignal& signal = message_->signals[number];
    const bool is_signed = signal.kind == DbcSignal::Kind::kSigned;
    fields_.push_back({signal.bits, is_signed ? std::uint64_t{1} << (signal.length - 1) : 0, signal.scale,
                       signal.offset, number, signal.kind,
                       signal.kind == DbcSignal::Kind::kUnsigned && signal.length == 64});
    group.bytes = std::max(group.bytes, signal.bytes());
  }
  groups_.push_back(group);
}

bool CompiledMessage::is_there(const Group& group, const RecordedFrame& frame,
                               std::span<const std::uint64_t> present) const {
  if ((present[group.multiplexer / 64] >> group.multiplexer % 64 & 1) == 0) return false;
  const std::uint64_t now = group.selector.raw(frame.data);
  const auto begin = cases_.begin() + group.range;
  return std::any_of(begin, begin + group.ranges, [&](const RawRange& range) { return range.holds(now); });
}

void CompiledMessage::decode_all(const RecordedFrame& frame, std::span<double> values,
                                 std::span<std::uint64_t> present) const {
  VOLTLAP_DEMAND(values.size() >= signals() && present.size() >= presence_words(signals()));
  std::fill_n(present.begin(), presence_words(signals()), 0);
  for (const Group& group : groups_) {
    if (group.multiplexer != kNone && !is_there(group, frame, present)) continue;
    const bool whole = group.bytes <= frame.length;
    for (std::uint32_t k = group.first; k < group.first + group.count; ++k) {
      const Field& field = fields_[k];
      if (!whole && field.bits.bytes() > frame.length) continue;
      const std::uint64_t raw = field.bits.raw(frame.data);
      if (field.kind <= DbcSignal::Kind::kSigned && !field.wide) [[likely]] {
        const double number = static_cast<double>(static_cast<std::int64_t>((raw ^ field.sign) - field.sign));
        values[field.number] = number * field.scale + field.offset;
      } else {
        values[field.number] = message_->signals[field.number].value(raw);
      }
      present[field.number / 64] |= std::uint64_t{1} << field.number % 64;
    }
  }
}

DbcDecoder::DbcDecoder(const DbcFile& file) {
  standard_.fill(-1);
  messages_.reserve(file.messages().size());
  for (const DbcMessage& message : file.messages()) {
    const auto at = static_cast<std::int32_t>(messages_.size());
    messages_.emplace_back(message);
    most_signals_ = std::max(most_signals_, message.signals.size());
    if (message.id < kStandard) {
      standard_[message.id] = at;
    } else {
      extended_[message.id] = at;
      if (message.j1939) groups_.try_emplace(parameter_group(message.id), at);
    }
  }
}

}  // namespace voltlap::plant
