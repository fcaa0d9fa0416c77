// SPDX-License-Identifier: Apache-2.0
#include "replay/shadow_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

std::string beside(double value, const char* unit) {
  return std::isfinite(value) ? fmt::format(" (the car's unit {:.1f} {})", value, unit) : "";
}

std::string limit_text(const char* name, double limit_a, double logged_a, const std::string& why) {
  return fmt::format("{} {:.0f} A, {}{}", name, limit_a, why, beside(logged_a, "A"));
}

/// The text without its numbers: what kind it is, of which fault.
std::string kind_of(const Disagreement& one) {
  std::string out;
  for (const char c : one.what) {
    if (!(c >= '0' && c <= '9') && c != '.' && c != '-') out += c;
  }
  return out.substr(0, out.find_first_of(";("));
}

}  // namespace

std::string status_text(const ReplayResult& result) {
  if (!result.never_ready.empty()) return "the firmware has not closed its contactors: " + result.never_ready;
  const auto row = std::find_if(result.rows.rbegin(), result.rows.rend(), [&](const ReplayRow& one) {
    return one.state == can::BmsState::kTsActive && (!result.has_cell_model() || std::isfinite(one.soc));
  });
  if (row == result.rows.rend()) return "the firmware has only just begun";
  const ReplayRow& now = *row;
  std::string out;
  if (result.has_cell_model()) {
    out = fmt::format("SOC {:.1f} %{} | {} | {} | ", 100.0 * now.soc, beside(100.0 * now.logged_soc, "%"),
                      limit_text("discharge", now.discharge_limit_a, now.logged_discharge_limit_a,
                                 reason_text(now.discharge_reason, now.limiting_cell)),
                      limit_text("charge", now.charge_limit_a, now.logged_charge_limit_a,
                                 reason_text(now.charge_reason, 0)));
  } else {
    out = "no cell model (--pack) | ";
  }
  return out + "faults " + (now.faults == 0 ? "none" : bms_fault_names(now.faults));
}

std::string waiting_text(const std::string& message) {
  constexpr std::string_view kFound = ": found ";
  const std::size_t at = message.find(kFound);
  const std::string found = at == std::string::npos ? message : message.substr(at + kFound.size());
  return found.substr(0, found.find_first_of(";\n"));
}

std::vector<Disagreement> NewDisagreements::of(const ReplayResult& result) {
  constexpr double kElsewhere_s = 1.0;
  std::vector<Disagreement> out;
  for (const Disagreement& one : result.disagreements) {
    const auto [at, is_new] = said_.try_emplace(kind_of(one), Said{one.begin_s, one.weight});
    const bool worse = one.weight > at->second.weight && std::abs(one.begin_s - at->second.begin_s) > kElsewhere_s;
    if (!is_new && !worse) continue;
    at->second = {one.begin_s, one.weight};
    out.push_back(one);
  }
  return out;
}

}  // namespace voltlap::plant
