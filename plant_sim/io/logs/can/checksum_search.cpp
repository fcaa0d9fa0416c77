// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/checksum_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "codec/crc8.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMostContents = 32, kTrial = 64;
constexpr std::size_t kShare = 20;       // one frame in so many may break the rule
constexpr std::uint8_t kModule = 0x39;   // of the Orion's thermistor expansion module
constexpr std::size_t kFixedContents = 2, kFreeContents = 4, kFreeLastBytes = 3, kFreePlaces = 2;

bool crc_holds(const RecordedFrame& frame) {
  const std::uint32_t id = frame.id & ~RecordedFrame::kExtendedFlag;
  const std::uint8_t* last = frame.data + frame.length - 1;
  std::uint8_t crc = codec::crc8_step(codec::kCrc8Start, static_cast<std::uint8_t>(id >> 8));
  crc = codec::crc8_step(crc, static_cast<std::uint8_t>(id));
  return codec::crc8_finish(std::accumulate(frame.data + 0, last, crc, codec::crc8_step)) == *last;
}

std::uint8_t constant_of(const RecordedFrame& frame) {
  const std::uint8_t* last = frame.data + frame.length - 1;
  return static_cast<std::uint8_t>(*last - std::accumulate(frame.data + 0, last, 0U));
}

}  // namespace

void ChecksumSearch::take(const RecordedFrame& frame) {
  if (given_up_) return;
  if (frames_++ == 0) {
    id_ = frame.id & ~RecordedFrame::kExtendedFlag;
    length_ = frame.length;
    given_up_ = frame.flexible || !frame.has_length || length_ < 2 || length_ > 8;
    if (given_up_) return;
  }
  if (frame.length != length_) {
    if (first_line_of_other_length_ == 0) first_line_of_other_length_ = frame.line;
    return;
  }
  const std::uint8_t constant = constant_of(frame);
  const bool crc = crc_holds(frame);
  if (constants_[constant]++ == 0) first_line_[constant] = static_cast<std::uint32_t>(frame.line);
  crc_holds_ += crc ? 1 : 0;
  if (!crc && first_line_without_crc_ == 0) first_line_without_crc_ = frame.line;
  keep(frame, constant, crc);
  // Most frames have no checksum: they are not to cost anything.
  if (frames_ == kTrial && !stands_out(std::max<std::size_t>(crc_holds_, constants_[most_frequent_constant()]))) {
    given_up_ = true;
  }
}

void ChecksumSearch::keep(const RecordedFrame& frame, std::uint8_t constant, bool crc) {
  if (contents_.size() == kMostContents) return;
  Content content{{}, constant, crc};
  std::copy_n(frame.data, frame.length, content.data.begin());
  const auto is_same = [&](const Content& known) { return known.data == content.data; };
  if (std::none_of(contents_.begin(), contents_.end(), is_same)) contents_.push_back(content);
}

/// While it is tried, twice as many may break the rule as in the end.
bool ChecksumSearch::stands_out(std::size_t holding) const { return (frames_ - holding) * kShare <= 2 * frames_; }

std::uint8_t ChecksumSearch::most_frequent_constant() const {
  return static_cast<std::uint8_t>(std::max_element(constants_.begin(), constants_.end()) - constants_.begin());
}

std::string ChecksumSearch::rule_of(std::uint8_t constant) const {
  std::string out;
  for (const auto& [rule_constant, words] : fixed_constants()) {
    if (rule_constant == constant) out += (out.empty() ? "" : ", or ") + std::string(words);
  }
  return out.empty() ? fmt::format("0x{:02X} + sum of the others", constant) : out;
}

/// Constants that follow from the frame itself, and what each is called; two may be the same number.
std::array<std::pair<std::uint8_t, const char*>, 4> ChecksumSearch::fixed_constants() const {
  const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value); };
  return {{{byte(id_ + length_), "identifier + length + sum of the others (Orion)"},
           {byte(std::uint32_t{kModule} + length_), "0x39 + length + sum of the others (Orion thermistor module)"},
           {byte(id_ + (id_ >> 8) + (id_ >> 16) + (id_ >> 24)), "bytes of the identifier + sum of the others"},
           {0, "sum of the others"}}};
}

/// A rule with nothing to be chosen holds by chance once in 65536 for two contents. Another constant is one of 256; a
/// byte that repeats another would follow it, too, and so would the plain sum: there more has to change.
bool ChecksumSearch::is_no_chance(bool crc, std::uint8_t constant) const {
  std::vector<const Content*> holding;
  for (const Content& content : contents_) {
    if (crc ? content.crc : content.constant == constant) holding.push_back(&content);
  }
  const auto values_at = [&](std::size_t place) {
    std::array<bool, 256> seen{};
    for (const Content* content : holding) seen[content->data[place]] = true;
    return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), true));
  };
  const std::size_t last_bytes = values_at(length_ - 1U);
  const auto known = fixed_constants();
  const bool fixed = std::any_of(known.begin(), known.end(), [&](const auto& rule) { return rule.first == constant; });
  if (crc || (fixed && constant != 0)) return holding.size() >= kFixedContents && last_bytes >= kFixedContents;
  std::size_t places = 0;
  for (std::size_t place = 0; place + 1 < length_; ++place) places += values_at(place) > 1 ? 1 : 0;
  return holding.size() >= kFreeContents && last_bytes >= kFreeLastBytes && places >= kFreePlaces;
}

std::optional<FoundChecksum> ChecksumSearch::found() const {
  if (given_up_ || frames_ < 2) return std::nullopt;
  const std::uint8_t constant = most_frequent_constant();
  const bool crc = crc_holds_ > constants_[constant];
  const std::size_t holds = crc ? crc_holds_ : constants_[constant];
  if ((frames_ - holds) * kShare > frames_ || !is_no_chance(crc, constant)) return std::nullopt;
  const std::string rule = crc ? "CRC-8 SAE J1850 of identifier and the others" : rule_of(constant);
  FoundChecksum out{rule, holds, frames_ - holds, 0};
  std::size_t line = first_line_of_other_length_;
  const auto take_earlier = [&](std::size_t other) {
    if (other != 0 && (line == 0 || other < line)) line = other;
  };
  if (crc) take_earlier(first_line_without_crc_);
  for (std::size_t k = 0; !crc && k < constants_.size(); ++k) {
    if (k != constant && constants_[k] > 0) take_earlier(first_line_[k]);
  }
  out.first_break_line = line;
  return out;
}

}  // namespace voltlap::plant
