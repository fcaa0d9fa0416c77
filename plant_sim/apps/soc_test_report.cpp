// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_test_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

const char* mark_text(bool is_met) { return is_met ? "met" : "NOT MET"; }

Json score_json(const SocScore& score) {
  return {{"rms_points", score.rms()}, {"max_points", score.largest()}, {"samples", score.samples()}};
}
Json mark_json(const SocMark& mark) { return {{"rms_points", mark.rms}, {"max_points", mark.largest}}; }

bool met(const SocScores& scores, const SocMark& mark) { return met(scores.pack, mark) && met(scores.weakest, mark); }

std::string drive_text(const SocDriveResult& drive) {
  std::string out = fmt::format(
      "{}, {}: {:.0f} s judged, charge at the end {:.1f} %{}\n"
      "  {:<34}{:>13}{:>15}{:>13}  {:<9}{:>16}\n",
      drive.course, drive.car, drive.trial.judged_s, drive.trial.drive.end_soc_pct,
      drive.trial.drive.finished ? "" : " (" + drive.trial.drive.failure_cause + ")", "the BMS is told", "ekf pack",
      "weakest cell", "mark", "", "coulomb pack");
  for (std::size_t i = 0; i < drive.trial.rows.size(); ++i) {
    const SocTrialRow& row = drive.trial.rows[i];
    const SocMark& mark = drive.marks[i];
    out += fmt::format("  {:<34}{:6.2f} {:6.2f}  {:6.2f} {:6.2f}  {:5.2f} {:5.2f}  {:<9}{:8.2f} {:7.2f}\n", row.name,
                       row.ekf.pack.rms(), row.ekf.pack.largest(), row.ekf.weakest.rms(), row.ekf.weakest.largest(),
                       mark.rms, mark.largest, mark_text(met(row.ekf, mark)), row.coulomb.pack.rms(),
                       row.coulomb.pack.largest());
  }
  return out + "\n";
}

std::string recording_text(const SocRecordingResult& recording) {
  const std::optional<SocMark> mark = mark_of(recording);
  std::string out = fmt::format(
      "{}: from {:.0f} %, judged at {:.0f} to {:.0f} %, {:.0f} s; 5 mV of OCV are {:.1f} points\n", recording.file,
      100.0 * recording.begin_soc, 100.0 * recording.low_soc, 100.0 * recording.high_soc, recording.judged_s,
      recording.slope_bound_points);
  for (const std::string& each : recording.remarks) out += "  " + each + "\n";
  for (const SocRecordingRow& row : recording.rows) {
    const bool judges = mark && row.ekf.samples() > 0;
    const std::string judged = judges ? fmt::format("{:5.2f} {:5.2f}  {:<9}", mark->rms, mark->largest,
                                                    mark_text(met(row.ekf, *mark)))
                                    : fmt::format("{:<22}", "not judged");
    out += fmt::format("  {:<34}{:6.2f} {:6.2f}  {:15}{}{:8.2f} {:7.2f}\n", row.name, row.ekf.rms(),
                       row.ekf.largest(), "", judged, row.coulomb.rms(), row.coulomb.largest());
  }
  return out + "\n";
}

Json drive_json(const SocDriveResult& drive) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < drive.trial.rows.size(); ++i) {
    const SocTrialRow& row = drive.trial.rows[i];
    rows.push_back({{"told", row.name},
                    {"ekf", {{"pack", score_json(row.ekf.pack)}, {"weakest", score_json(row.ekf.weakest)}}},
                    {"coulomb", {{"pack", score_json(row.coulomb.pack)}, {"weakest", score_json(row.coulomb.weakest)}}},
                    {"mark", mark_json(drive.marks[i])},
                    {"met", met(row.ekf, drive.marks[i])}});
  }
  return {{"course", drive.course},
          {"car", drive.car},
          {"finished", drive.trial.drive.finished},
          {"end_soc_pct", drive.trial.drive.end_soc_pct},
          {"judged_s", drive.trial.judged_s},
          {"rows", rows}};
}

Json recording_json(const SocRecordingResult& recording) {
  const std::optional<SocMark> mark = mark_of(recording);
  Json rows = Json::array();
  for (const SocRecordingRow& row : recording.rows) {
    rows.push_back({{"told", row.name},
                    {"ekf", score_json(row.ekf)},
                    {"coulomb", score_json(row.coulomb)},
                    {"mark", mark ? mark_json(*mark) : Json()},
                    {"met", mark && row.ekf.samples() > 0 ? Json(met(row.ekf, *mark)) : Json()}});
  }
  return {{"file", recording.file},
          {"remarks", recording.remarks},
          {"begin_soc", recording.begin_soc},
          {"low_soc", recording.low_soc},
          {"high_soc", recording.high_soc},
          {"judged_s", recording.judged_s},
          {"slope_bound_points", recording.slope_bound_points},
          {"rows", rows}};
}

/// Rows whose mark is met, and all.
std::pair<std::size_t, std::size_t> counted(const std::vector<SocDriveResult>& drives,
                                            const std::vector<SocRecordingResult>& recordings) {
  std::size_t good = 0, all = 0;
  for (const SocDriveResult& drive : drives) {
    all += drive.marks.size();
    for (std::size_t i = 0; i < drive.marks.size(); ++i) good += met(drive.trial.rows[i].ekf, drive.marks[i]) ? 1 : 0;
  }
  for (const SocRecordingResult& recording : recordings) {
    const std::optional<SocMark> mark = mark_of(recording);
    if (!mark) continue;
    for (const SocRecordingRow& row : recording.rows) {
      if (row.ekf.samples() == 0) continue;  // never under load, so that no record was read
      good += met(row.ekf, *mark) ? 1 : 0;
      ++all;
    }
  }
  return {good, all};
}

}  // namespace

bool met(const SocScore& score, const SocMark& mark) {
  return score.samples() > 0 && score.rms() <= mark.rms && score.largest() <= mark.largest;
}

std::optional<SocMark> mark_of(const SocRecordingResult& recording) {
  constexpr double kUseless_points = 25.0;
  const SocMark mark{std::max(kMarkTogether.rms, recording.slope_bound_points),
                     std::max(kMarkTogether.largest, 2.0 * recording.slope_bound_points)};
  return mark.rms > kUseless_points ? std::nullopt : std::optional(mark);
}

std::string soc_test_text(const std::vector<SocDriveResult>& drives,
                          const std::vector<SocRecordingResult>& recordings) {
  std::string out = "State of charge against the truth, in points of the full charge: RMS and largest error after the "
                    "first tenth of it.\n\n";
  for (const SocDriveResult& drive : drives) out += drive_text(drive);
  for (const SocRecordingResult& recording : recordings) out += recording_text(recording);
  const auto [good, all] = counted(drives, recordings);
  return out + fmt::format("marks met: {} of {}\n", good, all);
}

std::string soc_test_json(const std::vector<SocDriveResult>& drives,
                          const std::vector<SocRecordingResult>& recordings) {
  const auto [good, all] = counted(drives, recordings);
  Json out = {{"version", VOLTLAP_VERSION}, {"marks", all}, {"marks_met", good}};
  out["drives"] = Json::array();
  for (const SocDriveResult& drive : drives) out["drives"].push_back(drive_json(drive));
  out["recordings"] = Json::array();
  for (const SocRecordingResult& recording : recordings) out["recordings"].push_back(recording_json(recording));
  return out.dump(2) + "\n";
}

}  // namespace voltlap::plant
