// SPDX-License-Identifier: Apache-2.0
#include "io/play/frame_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "io/logs/can/can_recording.hpp"

namespace voltlap::plant {
namespace {

bool parse_id(std::string_view text, std::uint32_t& id) {
  constexpr std::uint32_t kLastStandard = 0x7FF, kLastExtended = 0x1FFFFFFF;
  constexpr std::size_t kStandardDigits = 3;
  if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id, 16);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() || id > kLastExtended) return false;
  if (text.size() > kStandardDigits || id > kLastStandard) id |= RecordedFrame::kExtendedFlag;
  return true;
}

}  // namespace

bool parse_id_range(std::string_view text, IdRange& out) {
  const std::size_t dash = text.find('-');
  IdRange range;
  if (!parse_id(text.substr(0, dash), range.first)) return false;
  range.last = range.first;
  if (dash != std::string_view::npos && !parse_id(text.substr(dash + 1), range.last)) return false;
  const bool one_kind = ((range.first ^ range.last) & RecordedFrame::kExtendedFlag) == 0;
  if (!one_kind || range.last < range.first) return false;
  out = range;
  return true;
}

std::string id_range_text(const IdRange& range) {
  if (range.first == range.last) return identifier_text(range.first);
  return fmt::format("{}-{}", identifier_text(range.first), identifier_text(range.last));
}

bool FrameChoice::has_id(std::uint32_t id) const {
  return ids.empty() || std::any_of(ids.begin(), ids.end(), [&](const IdRange& range) { return range.holds(id); });
}

}  // namespace voltlap::plant
