// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value, double unit = 1.0) { return std::isfinite(value) ? Json(value * unit) : Json(nullptr); }

Json of_node(const FrameComparison::Node& node) {
  return {{"recorded", node.recorded}, {"same", node.same}, {"different", node.different}, {"missing", node.missing},
          {"extra", node.extra}};
}

Json of_comparison(const FrameComparison& c) {
  Json out = {{"identical", c.identical()}, {"bms", of_node(c.bms)}, {"master", of_node(c.master)}};
  out["first_difference"] = nullptr;
  if (c.first) {
    out["first_difference"] = {{"time_s", c.first->time_s},
                               {"node", c.first->node},
                               {"message", c.first->message},
                               {"recorded", c.first->recorded},
                               {"answered", c.first->answered}};
  }
  return out;
}

Json of_over_limit(const OverLimit& o) {
  return {{"kind", o.charging ? "charge" : "discharge"},
          {"begin_s", o.begin_s},
          {"end_s", o.end_s},
          {"worst_s", o.worst_s},
          {"current_a", o.current_a},
          {"limit_a", o.limit_a},
          {"reason", can::kLimitReasonNames[static_cast<std::size_t>(o.reason)]},
          {"cell", o.cell > 0 ? Json(o.cell) : Json(nullptr)}};
}

/// To nine digits: 0.58, not 0.5800000000000003.
void round_all(Json& value) {
  if (value.is_number_float()) value = std::stod(fmt::format("{:.9g}", value.get<double>()));
  if (!value.is_structured()) return;
  for (Json& one : value) round_all(one);
}

template <class Items, class Convert>
Json list_of(const Items& items, const Convert& convert) {
  Json out = Json::array();
  for (const auto& item : items) out.push_back(convert(item));
  return out;
}

/// What the firmware said, at most some 200 moments of it: enough to see a change, small enough to keep.
Json series_of(const ReplayResult& r) {
  constexpr double kMost = 200.0, kRowsPer_s = 10.0;
  const auto rounded = [](double value, double unit) {
    return std::isfinite(value) ? Json(std::round(value * unit * 1e3) / 1e3) : Json(nullptr);
  };
  const auto every = static_cast<std::size_t>(std::max(1.0, std::ceil(static_cast<double>(r.rows.size()) / kMost)));
  Json out = {{"step_s", static_cast<double>(every) / kRowsPer_s}};
  for (const char* name : {"soc_pct", "discharge_limit_a", "charge_limit_a", "state"}) out[name] = Json::array();
  for (std::size_t k = 0; k < r.rows.size(); k += every) {
    const ReplayRow& row = r.rows[k];
    out["soc_pct"].push_back(rounded(row.soc, 100.0));
    out["discharge_limit_a"].push_back(rounded(row.discharge_limit_a, 1.0));
    out["charge_limit_a"].push_back(rounded(row.charge_limit_a, 1.0));
    out["state"].push_back(can::kBmsStateNames[static_cast<std::size_t>(row.state)]);
  }
  return out;
}

/// A field of a table of text; NaN is empty.
std::string field(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "";
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> out(1);
  for (const char c : line) {
    if (c == ',') {
      out.emplace_back();
    } else {
      out.back() += c;
    }
  }
  return out;
}

}  // namespace

std::string replay_json(const ReplayResult& r, const std::string& version) {
  Json out = {{"voltlap", version}, {"log", r.log}, {"map", r.map}};
  out["pack"] = r.has_cell_model() ? Json(r.pack) : Json("no cell model");
  out["frames"] = r.frames.in_file;
  out["frames_by_verdict"] = {
      {"used", r.frames.used}, {"ignored", r.frames.ignored}, {"corrupt", r.frames.corrupt}, {"stale", r.frames.stale}};
  out["begin_s"] = r.begin_s;
  out["duration_s"] = r.duration_s;
  out["cells"] = r.cells;
  out["soc_start_pct"] = number(r.soc_start(), 100.0);
  out["soc_start_from"] = r.has_cell_model() ? Json(kSocSourceNames[static_cast<std::size_t>(r.soc_from)]) : Json();
  out["soc_end_pct"] = number(r.soc_end(), 100.0);
  out["soc_logged_start_pct"] = number(r.logged_soc_start(), 100.0);
  out["soc_logged_end_pct"] = number(r.logged_soc_end(), 100.0);
  out["series"] = series_of(r);
  out["limit_violations"] = list_of(r.violations, [](const LimitViolation& v) {
    return Json{{"time_s", v.time_s},       {"until_s", v.until_s}, {"worst_s", v.worst_s}, {"cell", v.cell},
                {"voltage_v", v.voltage_v}, {"limit_v", v.limit_v}};
  });
  out["over_limits"] = list_of(r.over_limits, of_over_limit);
  out["faults"] = list_of(r.faults, [](const ReplayFault& f) {
    return Json{{"id", f.id}, {"node", f.node}, {"time_s", f.time_s}, {"opens", f.opens}, {"about", f.about}};
  });
  out["defects"] = list_of(r.defects, [](const LogDefect& d) {
    return Json{{"kind", d.kind}, {"channel", d.channel}, {"count", d.count}, {"first_s", d.first_s}, {"text", d.text}};
  });
  out["disagreements"] = list_of(r.disagreements, [](const Disagreement& d) {
    return Json{{"what", d.what}, {"begin_s", d.begin_s}, {"end_s", d.end_s}, {"decided_by", d.decided_by},
                {"weight", d.weight}};
  });
  out["logged_faults"] = list_of(r.logged_faults, [](const LoggedFault& f) {
    return Json{{"role", f.role}, {"source", f.source}, {"time_s", f.time_s}, {"value", f.value}};
  });
  out["cells_end"] = list_of(r.estimates, [](const CellEstimate& c) {
    return Json{{"cell", c.cell},
                {"soc_pct", number(c.soc, 100.0)},
                {"resistance_of_pack_file", number(c.resistance)},
                {"resistance_sd", number(c.resistance_sd)},
                {"capacity_ah", number(c.capacity_ah)},
                {"capacity_sd_ah", number(c.capacity_sd_ah)}};
  });
  out["comparison"] = r.comparison ? of_comparison(*r.comparison) : Json(nullptr);
  out["never_ready"] = r.never_ready.empty() ? Json(nullptr) : Json(r.never_ready);
  out["contactors_open_s"] = r.open_s;
  out["contactors_open_ah"] = r.open_ah;
  out["soc_jump"] = nullptr;
  if (r.soc_jump) {
    out["soc_jump"] = {{"begin_s", r.soc_jump->begin_s},
                       {"end_s", r.soc_jump->end_s},
                       {"from_pct", 100.0 * r.soc_jump->from},
                       {"to_pct", 100.0 * r.soc_jump->to},
                       {"charge_ah", r.soc_jump->charge_ah}};
  }
  out["assumptions"] = r.assumptions;
  out["notes"] = r.notes;
  round_all(out);
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string replay_csv(const ReplayResult& r) {
  std::string out =
      "time_s,current_a,cell_min_v,cell_max_v,temperature_max_c,soc_pct,soc_logged_pct,discharge_limit_a,"
      "discharge_limit_logged_a,charge_limit_a,charge_limit_logged_a,discharge_reason,charge_reason,limiting_cell,"
      "state,faults\n";
  for (const ReplayRow& row : r.rows) {
    out += fmt::format("{:.2f},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", row.time_s, field(row.current_a, 3),
                       field(row.cell_min_v, 4), field(row.cell_max_v, 4), field(row.temperature_max_c, 1),
                       field(100.0 * row.soc, 3), field(100.0 * row.logged_soc, 3), field(row.discharge_limit_a, 1),
                       field(row.logged_discharge_limit_a, 1), field(row.charge_limit_a, 1),
                       field(row.logged_charge_limit_a, 1),
                       can::kLimitReasonNames[static_cast<std::size_t>(row.discharge_reason)],
                       can::kLimitReasonNames[static_cast<std::size_t>(row.charge_reason)], row.limiting_cell,
                       can::kBmsStateNames[static_cast<std::size_t>(row.state)], row.faults);
  }
  return out;
}

std::vector<ReplayRow> rows_of_csv(const std::string& text) {
  std::vector<ReplayRow> out;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = fields_of(line);
  while (std::getline(lines, line)) {
    const std::vector<std::string> fields = fields_of(line);
    ReplayRow row;
    for (std::size_t k = 0; k < names.size() && k < fields.size(); ++k) {
      if (names[k] == "state" && fields[k] == can::kBmsStateNames[static_cast<std::size_t>(can::BmsState::kTsActive)]) {
        row.state = can::BmsState::kTsActive;
      }
      if (fields[k].empty()) continue;
      if (names[k] == "time_s") row.time_s = std::stod(fields[k]);
      if (names[k] == "soc_pct") row.soc = 1e-2 * std::stod(fields[k]);
      if (names[k] == "discharge_limit_a") row.discharge_limit_a = std::stod(fields[k]);
      if (names[k] == "charge_limit_a") row.charge_limit_a = std::stod(fields[k]);
    }
    out.push_back(row);
  }
  return out;
}

}  // namespace voltlap::plant
