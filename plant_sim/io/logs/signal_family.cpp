// SPDX-License-Identifier: Apache-2.0
#include "io/logs/signal_family.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kLeast = 2;

/// A name in two parts: that of all modules, and which module it is.
struct OfModule {
  std::string pattern;
  long module = 0;
};

/// "M1C<n>" is "M<m>C<n>" of module 1; "B<n> [V]" is "<m><n> [V]" of module 2.
std::optional<OfModule> of_module(const std::string& pattern) {
  const std::size_t number_at = pattern.find("<n>");
  VOLTLAP_DEMAND(number_at != std::string::npos);
  const auto is_digit = [&](std::size_t k) { return std::isdigit(static_cast<unsigned char>(pattern[k])) != 0; };
  std::size_t begin = 0;
  while (begin < number_at && !is_digit(begin)) ++begin;
  std::size_t end = begin;
  while (end < number_at && is_digit(end)) ++end;
  if (end > begin && end - begin < 4) {
    return OfModule{pattern.substr(0, begin) + "<m>" + pattern.substr(end),
                    std::stol(pattern.substr(begin, end - begin))};
  }
  const bool letter = number_at == 1 && std::isalpha(static_cast<unsigned char>(pattern[0])) != 0;
  if (!letter) return std::nullopt;
  return OfModule{"<m>" + pattern.substr(1), std::toupper(static_cast<unsigned char>(pattern[0])) - 'A' + 1};
}

bool is_called_so(const SignalCandidate& candidate, FamilyKind kind) {
  const SpokenName& name = candidate.name;
  if (kind == FamilyKind::kThermistors) return name.owner != Owner::kWheel && candidate.is_called_temperature();
  const bool bare = name.owner == Owner::kCell && name.meaning == Meaning::kNothing && !candidate.signal->unit;
  return bare || candidate.is_of(Quantity::kVoltage, Meaning::kVoltage);
}

bool is_sound(const SignalFamily& family, FamilyKind kind) {
  const auto in_range = [&](const SignalCandidate& candidate) {
    return kind == FamilyKind::kCells ? candidate.is_cell_voltage() : candidate.is_temperature();
  };
  const auto sound = std::count_if(family.members.begin(), family.members.end(), in_range);
  return 2 * sound >= std::ssize(family.members);
}

void sort_by_number(SignalFamily& family) {
  std::stable_sort(family.members.begin(), family.members.end(),
                   [](const SignalCandidate& a, const SignalCandidate& b) { return *a.name.number < *b.name.number; });
}

/// Families of one number each; those that are modules of one pack together as one more.
std::vector<SignalFamily> with_modules(const std::map<std::string, SignalFamily>& families) {
  struct Module {
    long number;
    const SignalFamily* cells;
  };
  std::map<std::string, std::vector<Module>> packs;
  std::vector<SignalFamily> out;
  for (const auto& [key, family] : families) {
    out.push_back(family);
    if (const auto part = of_module(family.members.front().name.pattern)) {
      packs[family.members.front().signal->source.dbc + part->pattern].push_back({part->module, &family});
    }
  }
  for (auto& [pattern, modules] : packs) {
    if (modules.size() < 2) continue;
    std::sort(modules.begin(), modules.end(), [](const Module& a, const Module& b) { return a.number < b.number; });
    SignalFamily pack;
    pack.of_modules = true;
    for (const Module& module : modules) {
      for (SignalCandidate member : module.cells->members) {
        member.name.number = std::ssize(pack.members) + 1;
        pack.members.push_back(member);
      }
    }
    out.push_back(std::move(pack));
  }
  return out;
}

}  // namespace

SignalFamily largest_family(const std::vector<SignalCandidate>& candidates, FamilyKind kind) {
  std::map<std::string, SignalFamily> families;
  for (const SignalCandidate& candidate : candidates) {
    if (candidate.name.pattern.empty() || !is_called_so(candidate, kind)) continue;
    families[candidate.signal->source.dbc + candidate.name.pattern].members.push_back(candidate);
  }
  for (auto& [key, family] : families) sort_by_number(family);
  SignalFamily out;
  const auto rank = [](const SignalFamily& family) {
    return std::tuple(family.members.front().name.is_plain ? 1 : 0, family.members.size());
  };
  for (SignalFamily& family : with_modules(families)) {
    if (family.members.size() < kLeast || !is_sound(family, kind)) continue;
    if (out.members.empty() || rank(family) > rank(out)) out = std::move(family);
  }
  return out;
}

}  // namespace voltlap::plant
