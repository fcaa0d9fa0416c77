// SPDX-License-Identifier: Apache-2.0
// A proposal as the file that --map takes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/demand.hpp"
#include "io/logs/map_proposal.hpp"
#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
      continue;
    }
    out += c;
  }
  return out + '"';
}

std::string where(const RoleSource& source) {
  if (!source.frame) return "column = " + quoted(source.column);
  const std::uint32_t id = *source.frame & ~RecordedFrame::kExtendedFlag;
  const bool small_extended = id != *source.frame && id <= 0x7FF;
  std::string out =
      fmt::format("frame = 0x{:03X}{}, signal = {}, dbc = {}", id, small_extended ? ", extended = true" : "",
                  quoted(source.signal), quoted(source.dbc));
  if (source.last_frame)
    out += fmt::format(", last_frame = 0x{:03X}", *source.last_frame & ~RecordedFrame::kExtendedFlag);
  if (!source.bus.empty()) out += ", bus = " + quoted(source.bus);
  return out;
}

/// The unit, and what is left of scale and offset beside it.
std::string unit_of_entry(const std::string& role, const RoleSource& source) {
  std::string out;
  double scale = source.scale, offset = source.offset;
  const std::vector<std::string_view> known = units_of(role);
  if (!source.unit.empty() && std::find(known.begin(), known.end(), source.unit) != known.end()) {
    const Unit unit = unit_of("", source.unit);
    scale /= unit.scale;
    offset = (offset - unit.offset) / unit.scale;
    out = ", unit = " + quoted(source.unit);
  }
  if (std::abs(scale - 1.0) > 1e-12) out += fmt::format(", scale = {:.12g}", scale);
  if (std::abs(offset) > 1e-9) out += fmt::format(", offset = {:.12g}", offset);
  return out;
}

std::string line_of(const ProposedRole& proposed) {
  const RoleSource& source = proposed.source;
  const bool bare = proposed.role.find('<') == std::string::npos;
  std::string out = fmt::format("{} = {{{}{}", bare ? proposed.role : quoted(proposed.role), where(source),
                                unit_of_entry(proposed.role, source));
  if (source.first) out += fmt::format(", first = {}", *source.first);
  if (proposed.role == "current") {
    const char* signs[] = {"+", "-", "auto"};
    out += fmt::format(", discharge = \"{}\"", signs[static_cast<std::size_t>(source.discharge)]);
  }
  return out + "}";
}

/// Roles that differ in a number alone have one.
std::string family_of(const ProposedRole& proposed) {
  const std::size_t end = proposed.role.find_last_not_of("0123456789");
  return proposed.role.substr(0, end + 1) + " " + proposed.evidence;
}

}  // namespace

std::string MapProposal::draft() const {
  std::string out = "[roles]\n";
  for (const ProposedRole& role : roles) out += fmt::format("{}  # {}\n", line_of(role), role.evidence);
  for (const OpenChoice& choice : open) {
    if (choice.candidates.empty()) {
      out += fmt::format("# {} is missing: {}\n", choice.role, choice.why);
      continue;
    }
    out += fmt::format("# {}: {}. Choose one, take its # away and delete the others:\n", choice.role, choice.why);
    for (const ProposedRole& candidate : choice.candidates)
      out += fmt::format("#{}  # {}\n", line_of(candidate), candidate.evidence);
  }
  return out;
}

const ProposedRole* MapProposal::find(const std::string& role) const {
  const auto at = std::find_if(roles.begin(), roles.end(), [&](const ProposedRole& r) { return r.role == role; });
  return at == roles.end() ? nullptr : &*at;
}

RoleMap MapProposal::map() const {
  VOLTLAP_DEMAND(is_complete() && !roles.empty());
  RoleMap out;
  out.source = "proposed map";
  std::map<std::string, std::size_t> numbered;  // by stem and evidence: cells are said once
  for (const ProposedRole& role : roles) ++numbered[family_of(role)];
  for (const ProposedRole& role : roles) {
    out.roles[role.role] = role.source;
    const std::size_t alike = std::exchange(numbered[family_of(role)], 0);
    if (alike == 0) continue;
    const std::string others = alike > 1 ? fmt::format(", and {} more like it", alike - 1) : "";
    out.notes.push_back(fmt::format("no map: {} is {}{} ({})", role.role, role.described, others, role.evidence));
  }
  out.notes.insert(out.notes.end(), notes.begin(), notes.end());
  return out;
}

}  // namespace voltlap::plant
