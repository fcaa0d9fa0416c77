// SPDX-License-Identifier: Apache-2.0
#include "learn/methods/method_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/demand.hpp"
#include "core/number_text.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

constexpr StudyScore kStudy[] = {{"ipo", 1.9e-4, 1.5e-5, 1110.0, 30.0},
                                 {"fpo", 1.3e-4, 6.8e-6, 1451.0, 0.0},
                                 {"ilo", 1.5e-3, 6.5e-4, 608.0, 0.0},
                                 {"flo", 6.5e-5, 6.7e-6, 924.0, 0.0},
                                 {"ffo", 6.3e-6, 4.5e-6, 1834.0, 120.0}};

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

MethodScore method_score(const std::string& name, const std::vector<CellIdentification>& cells) {
  MethodScore out{name};
  std::vector<double> sections, snr, whole, floor;
  for (const CellIdentification& cell : cells) {
    for (const OperatingPoint& point : cell.points) {
      for (const SectionScore& section : point.result.sections) {
        sections.push_back(section.square_v2);
        snr.push_back(section.snr);
      }
      for (const RecordingResult& file : point.result.files) {
        whole.push_back(file.rms_v * file.rms_v);
        floor.push_back(point.result.noise_floor_v2);
      }
      out.seconds += point.result.seconds;
    }
  }
  VOLTLAP_DEMAND(!sections.empty() && !whole.empty());
  out.tests = whole.size();
  out.sections = sections.size();
  out.seconds /= static_cast<double>(whole.size());
  out.mean_v2 = mean_of(sections);
  out.median_v2 = median(sections);
  out.snr = mean_of(snr);
  out.whole_mean_v2 = mean_of(whole);
  out.whole_median_v2 = median(whole);
  out.noise_floor_v2 = mean_of(floor);
  return out;
}

const StudyScore* study_score(const std::string& name) {
  const auto* found =
      std::find_if(std::begin(kStudy), std::end(kStudy), [&](const StudyScore& row) { return name == row.name; });
  return found == std::end(kStudy) ? nullptr : found;
}

std::string square_millivolts(double square_v2) {
  constexpr double kPerSquareVolt = 1e6;
  return significant(kPerSquareVolt * square_v2, 2);
}

std::string comparison_text(const std::vector<MethodScore>& scores) {
  VOLTLAP_DEMAND(!scores.empty());
  std::string out = fmt::format(
      "Mean square error in mV2 over {} tests; noise of the voltage's instrument {} mV2\n"
      "                 by section                    whole tests, as written        time    reference study, 2016\n"
      "  method  sections     mean   median    SNR        mean   median    "
      "  a test    mean   median    SNR      time\n",
      scores.front().tests, square_millivolts(scores.front().noise_floor_v2));
  for (const MethodScore& s : scores) {
    out += fmt::format("  {:<6}  {:8}  {:>7}  {:>7}  {:5.0f}     {:>7}  {:>7}  {:8.2f} s", s.name, s.sections,
                       square_millivolts(s.mean_v2), square_millivolts(s.median_v2), s.snr,
                       square_millivolts(s.whole_mean_v2), square_millivolts(s.whole_median_v2), s.seconds);
    if (const StudyScore* study = study_score(s.name)) {
      out += fmt::format("  {:>7}  {:>7}  {:5.0f}", square_millivolts(study->mean_v2),
                         square_millivolts(study->median_v2), study->snr);
      out += study->minutes > 0.0 ? fmt::format("  {:4.0f} min", study->minutes) : "         -";
    }
    out += "\n";
  }
  return out +
         "  Sections are pulses (ipo, fpo), layers (ilo, flo) or whole tests (ffo, full), each as its method left it;\n"
         "  whole tests are run with the tables as the cell file holds them. Study: its own cells and instruments.\n";
}

std::string with_methods(const std::string& identification, const std::vector<MethodScore>& scores) {
  Json out = Json::parse(identification);
  for (const MethodScore& s : scores) {
    Json row = {{"method", s.name},
                {"tests", s.tests},
                {"sections", s.sections},
                {"section_mean_v2", s.mean_v2},
                {"section_median_v2", s.median_v2},
                {"snr", s.snr},
                {"whole_mean_v2", s.whole_mean_v2},
                {"whole_median_v2", s.whole_median_v2},
                {"noise_floor_v2", s.noise_floor_v2},
                {"seconds_per_test", s.seconds}};
    const StudyScore* study = study_score(s.name);
    row["study"] = study == nullptr ? Json()
                                    : Json{{"mean_v2", study->mean_v2},
                                           {"median_v2", study->median_v2},
                                           {"snr", study->snr},
                                           {"minutes_per_cell", study->minutes > 0.0 ? Json(study->minutes) : Json()}};
    out["methods"].push_back(row);
  }
  return out.dump(2) + "\n";
}

}  // namespace voltlap::plant
