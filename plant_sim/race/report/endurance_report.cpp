// SPDX-License-Identifier: Apache-2.0
#include "race/report/endurance_report.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "core/demand.hpp"
#include "io/page/html_page.hpp"
#include "race/report/endurance_report_body.hpp"
#include "race/report/run_text.hpp"
#include "race/report/time_series_file.hpp"
#include "race/track/outline.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kOutlineStep_m = 2.0;

/// Of html/, in the order in which they need each other.
constexpr std::array<std::string_view, 11> kScripts = {
    "series.js",    "time_charts.js", "time_chart.js", "chart_gestures.js",   "curve_family.js",
    "track_map.js", "energy_flow.js", "run_frames.js", "endurance_charts.js", "cell_temperatures.js",
    "endurance.js"};

/// A signal of the charts, kept in steps of what its sensor or CAN signal resolves.
struct Column {
  const char* name;
  double resolution;
  double (*value)(const TimeSample&);
};

std::size_t weakest(const TimeSample& s) {
  return static_cast<std::size_t>(std::distance(
      s.cell_voltage_v->begin(), std::min_element(s.cell_voltage_v->begin(), s.cell_voltage_v->end())));
}

/// Number, from 1, of the cell whose temperature `of` finds.
template <class Extreme>
double number_of(const TimeSample& s, Extreme of) {
  return static_cast<double>(1 + std::distance(s.cell_temperature_c->begin(), of(*s.cell_temperature_c)));
}

constexpr Column kColumns[] = {
    {"distance_m", 0.01, [](const TimeSample& s) { return s.distance_m; }},
    {"speed_mps", 0.01, [](const TimeSample& s) { return s.speed_mps; }},
    {"target_mps", 0.01, [](const TimeSample& s) { return s.target_mps; }},
    {"accelerator", 0.001, [](const TimeSample& s) { return s.accelerator; }},
    {"brake", 0.001, [](const TimeSample& s) { return s.brake; }},
    {"pack_current_a", 0.1, [](const TimeSample& s) { return s.pack_current_a; }},
    {"discharge_limit_a", 0.1, [](const TimeSample& s) { return s.discharge_limit_a; }},
    {"limit_reason", 1.0, [](const TimeSample& s) { return static_cast<double>(s.limit_reason); }},
    {"pack_voltage_v", 0.01, [](const TimeSample& s) { return s.pack_voltage_v; }},
    {"cell_voltage_min_v", 0.001, [](const TimeSample& s) { return (*s.cell_voltage_v)[weakest(s)]; }},
    {"cell_weakest", 1.0, [](const TimeSample& s) { return static_cast<double>(weakest(s) + 1); }},
    {"soc", 0.0001, [](const TimeSample& s) { return s.soc; }},
    {"bms_soc", 0.0001, [](const TimeSample& s) { return std::isnan(s.bms_soc) ? 0.0 : s.bms_soc; }},
    {"battery_temperature_c", 0.02, [](const TimeSample& s) { return s.battery_temperature_c; }},
    {"motor_temperature_c", 0.1, [](const TimeSample& s) { return s.motor_temperature_c; }},
    {"front_rotor_c", 0.1, [](const TimeSample& s) { return s.front_rotor_c; }},
    {"rear_rotor_c", 0.1, [](const TimeSample& s) { return s.rear_rotor_c; }},
    {"course_m", 0.01, [](const TimeSample& s) { return s.course_m; }},
    {"power_w", 10.0, [](const TimeSample& s) { return s.power_w; }},
    {"power_mean_w", 10.0, [](const TimeSample& s) { return s.power_mean_w; }},
    {"longitudinal_mps2", 0.01, [](const TimeSample& s) { return s.longitudinal_mps2; }},
    {"lateral_mps2", 0.01, [](const TimeSample& s) { return s.lateral_mps2; }},
    {"cell_hottest", 1.0, [](const TimeSample& s) { return number_of(s, std::ranges::max_element); }},
    {"cell_coldest", 1.0, [](const TimeSample& s) { return number_of(s, std::ranges::min_element); }},
    {"cell_temperature_min_c", 0.02,
     [](const TimeSample& s) { return *std::min_element(s.cell_temperature_c->begin(), s.cell_temperature_c->end()); }},
};

Json columns_json(const std::vector<HtmlSeries>& columns) {
  Json out = Json::object();
  for (const HtmlSeries& column : columns) {
    out[column.name()] = {{"resolution", column.resolution()}, {"deltas", column.base64()}};
  }
  return out;
}

/// The true extremes, taken at every integration step; samples fall beside them.
Json extremes(const EnduranceResult& r) {
  const ExtremeTimes& at = r.extreme_times;
  const auto point = [](double time_s, double value) { return Json{{"time_s", time_s}, {"value", value}}; };
  return {{"pack_current_a", point(at.battery_current_s, r.max_battery_current_a)},
          {"speed_mps", point(at.speed_s, r.max_speed_mps)},
          {"pack_voltage_v", point(at.pack_voltage_s, r.min_pack_voltage_v)},
          {"cell_voltage_min_v", point(at.cell_voltage_s, r.min_cell_voltage_v)},
          {"battery_temperature_c", point(at.battery_temp_s, r.max_battery_temp_c)},
          {"power_w", point(at.power_s, r.max_power_w)},
          {"power_mean_w", point(at.power_mean_s, r.max_power_mean_w)},
          {"motor_temperature_c", point(at.motor_temp_s, r.max_motor_temp_c)},
          {"soc", point(r.total_time_s, r.end_soc_pct / 100.0)}};
}

Json limits(const EnduranceResult& result) {
  Json out = Json::array();
  for (std::size_t i = 0; i < kLimitReasons; ++i) {
    out.push_back({{"name", limit_reason_name(i)}, {"active_s", result.limit_active_s[i]}});
  }
  return out;
}

Json laps(const EnduranceResult& result) {
  Json out = Json::array();
  double start_s = 0.0;
  for (const LapRow& row : result.lap_rows) {
    out.push_back({{"lap", row.lap}, {"start_s", start_s}, {"end_s", start_s + row.time_s}});
    start_s += row.time_s;
  }
  return out;
}

Json course(const std::optional<Track>& track) {
  if (!track) return nullptr;
  Json distance = Json::array(), x = Json::array(), y = Json::array();
  const auto decimetres = [](double metres) { return std::round(metres * 10.0) / 10.0; };
  for (const OutlinePoint& point : outline(*track, kOutlineStep_m)) {
    distance.push_back(decimetres(point.distance_m));
    x.push_back(decimetres(point.x_m));
    y.push_back(decimetres(point.y_m));
  }
  return {{"name", track->name}, {"length_m", track->length_m()}, {"distance_m", distance}, {"x_m", x}, {"y_m", y}};
}

Json ledger(const EnergyLedger& terms) {
  Json out = Json::object();
  for (std::size_t i = 0; i < kEnergyTerms; ++i) {
    const auto term = static_cast<EnergyTerm>(i);
    out[energy_term_name(term)] = terms[term] / kJoulesPerKwh;
  }
  return out;
}

}  // namespace

HtmlReport::HtmlReport(const std::string& path) : file_(path) {
  for (const Column& column : kColumns) columns_.emplace_back(column.name, column.resolution);
}

void HtmlReport::add(const TimeSample& sample) {
  VOLTLAP_DEMAND(sample.cell_voltage_v != nullptr && !sample.cell_voltage_v->empty());
  VOLTLAP_DEMAND(sample.cell_temperature_c != nullptr);
  VOLTLAP_DEMAND(columns_.size() == std::size(kColumns));
  cells_.add(sample.time_s, *sample.cell_temperature_c);
  if (count_ == 0) first_s_ = sample.time_s;
  if (count_++ % every_ != 0) return;
  for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i].add(kColumns[i].value(sample));
  if (columns_[0].size() <= kSamplesMax) return;
  for (HtmlSeries& column : columns_) column.halve();
  every_ *= 2;
}

std::string HtmlReport::data(const ReportedRun& reported) const {
  const EnduranceResult& result = reported.result;
  const Json json = {
      {"course_name", reported.run.course},
      {"by_position", reported.run.lap_start == "flying"},
      {"cells_alike", cells_alike(reported.run, reported.car.parameters)},
      {"failure", result.finished ? Json() : Json(result.failure_cause)},
      {"end_s", result.total_time_s},
      {"samples", columns_[0].size()},
      {"first_s", first_s_},
      {"period_s", static_cast<double>(every_) / TimeSeriesFile::kSamplesPerSecond},
      {"columns", columns_json(columns_)},
      {"bms_counts", result.bms_counts},
      {"cells", cells_.json()},
      {"extremes", extremes(result)},
      {"limits", limits(result)},
      {"laps", laps(result)},
      {"laps_asked", reported.run.laps},
      {"course", course(reported.track)},
      {"energy_kwh", ledger(result.ledger)},
  };
  // As in run_result_json: a file name need not be UTF-8, JSON must.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void HtmlReport::finish(const ReportedRun& reported) {
  const std::string sentence = headline(reported.run, reported.car.parameters, reported.result);
  file_.write(html_page({.title = reported.run.vehicle + " on " + reported.run.course + ", voltlap endurance",
                         .description = sentence,
                         .body = html_report_body(reported),
                         .scripts = {kScripts.begin(), kScripts.end()},
                         .data = data(reported),
                         .own = endurance_page_files}));
  file_.complete();
}

}  // namespace voltlap::plant
