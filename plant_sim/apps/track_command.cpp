// SPDX-License-Identifier: Apache-2.0
#include "apps/track_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/progress_line.hpp"
#include "io/atomic_file.hpp"
#include "race/track/import/course_picture.hpp"

namespace voltlap::plant {
namespace {

constexpr double kMetresPerFoot = 0.3048;

nlohmann::ordered_json json_of(const Track& track, const CourseSummary& sum) {
  return {{"name", track.name},
          {"length_m", sum.length_m},
          {"segments", track.segments.size()},
          {"corners", sum.corners},
          {"straights_m", sum.straights_m},
          {"tightest_radius_m", sum.tightest_radius_m},
          {"tightest_at_m", sum.tightest_at_m},
          {"turned_deg", sum.turned_deg},
          {"climb_m", sum.climb_m},
          {"rise_m", sum.rise_m},
          {"closing_gap_m", sum.gap_m}};
}

nlohmann::ordered_json json_of(const ImportedCourse& course, const CourseSummary& sum) {
  nlohmann::ordered_json out = json_of(course.track, sum);
  out["source_kind"] = name_of(course.kind);
  out["closed"] = course.closed;
  out["source_gap_m"] = course.source_gap_m;
  out["points"] = course.points;
  out["points_used"] = course.points_used;
  out["start_point"] = course.start_point;
  out["laps_found"] = course.laps;
  out["laps_used"] = course.laps_used;
  out["noise_m"] = course.noise_m ? nlohmann::ordered_json(*course.noise_m) : nlohmann::ordered_json(nullptr);
  out["noise_origin"] = course.noise_origin;
  out["notes"] = course.notes;
  return out;
}

std::string summary_text(const CourseSummary& sum, std::size_t segments) {
  std::string text =
      fmt::format("  length     {:8.1f} m in {} segments, {:.1f} m of it straight (radius above 100 m)\n", sum.length_m,
                  segments, sum.straights_m);
  text += fmt::format("  corners    {:8} (one way round, radius below 100 m, 10 degrees or more)\n", sum.corners);
  if (sum.tightest_radius_m > 0.0) {
    text += fmt::format("  tightest   {:8.2f} m radius, {:.1f} m behind the start\n", sum.tightest_radius_m,
                        sum.tightest_at_m);
  }
  if (sum.climb_m > 0.0 || sum.rise_m < 0.0) {
    const bool level = std::abs(sum.rise_m) < 0.01;
    text += fmt::format("  climb      {:8.1f} m, its end {}\n", sum.climb_m,
                        level ? "as high as its start"
                              : fmt::format("{:.1f} m {} its start: each lap goes on from there", std::abs(sum.rise_m),
                                            sum.rise_m > 0.0 ? "above" : "below"));
  }
  return text + fmt::format("  turned     {:8.1f} degrees to the right\n  gap        {:8.2f} m from end to start\n",
                            sum.turned_deg, sum.gap_m);
}

std::string origin_text(const ImportedCourse& course) {
  const bool points = course.noise_m.has_value();
  std::string text = fmt::format("  source     {:8} {}, {} used\n", course.points, points ? "points" : "segments",
                                 course.points_used);
  if (course.laps > 0) {
    text += fmt::format("  laps       {:8} found, {}\n", course.laps,
                        course.laps_used == course.laps && course.laps > 1 ? "the course is their mean"
                        : course.laps > 1                                  ? "one used"
                                                                           : "used");
  }
  if (points) text += fmt::format("  start             at point {} of the source\n", course.start_point);
  if (!course.closed) {
    text += fmt::format(
        "  open              the source ends {:.1f} m from its start; drive it with --lap-start standing\n",
        course.source_gap_m);
  } else if (points) {
    text += fmt::format("  closed            the source's gap of {:.2f} m was bridged\n", course.source_gap_m);
  } else {
    text += "  closed            taken as it stands, the gap is not shared out\n";
  }
  if (points) {
    text += fmt::format("  noise      {:8.3f} m across the course, {}\n", *course.noise_m, course.noise_origin);
  }
  for (const std::string& note : course.notes) text += fmt::format("  note              {}\n", note);
  return text;
}

std::string caption(const Track& track, const CourseSummary& sum) {
  return fmt::format("{}: {:.0f} m, {} corners", track.name, sum.length_m, sum.corners);
}

void commit_all(std::initializer_list<std::optional<AtomicFile>*> files) {
  for (auto* file : files) {
    if (*file) (*file)->complete();
  }
  for (auto* file : files) {
    if (*file) (*file)->commit();
  }
}

std::optional<AtomicFile> output(const std::string& path) {
  return path.empty() ? std::nullopt : std::optional<AtomicFile>(std::in_place, path);
}

}  // namespace

TrackCommand::TrackCommand(CLI::App& app)
    : command_(app.add_subcommand("track", "A course file from points, GPS, cones or curvature; what a course is")) {
  command_->require_subcommand(1);
  add_import();
  add_show();
}

void TrackCommand::add_import() {
  import_ = command_->add_subcommand("import", "Make a course file that --track of lap and endurance reads");
  import_->add_option("source", source_, "CSV (any separator, header or none; .gz) or GPX")->required();
  add_output_file(*import_, "--out", out_, "The course file; -: to standard output")->required();
  import_->add_option("--as", kind_, "What the source is, where the columns do not say it")
      ->check(one_of({"points", "gps", "gates", "curvature", "segments"}));
  import_->add_option("--unit", unit_, "Of the lengths, where the columns do not name it")->check(one_of({"m", "ft"}));
  import_->add_option("--noise", noise_m_,
                      "Standard deviation of the points across the course in metres, instead of the one measured from "
                      "them; more of it smooths more, 0 takes the points as exact")
      ->type_name("M")
      ->check(number_between(0.0, 20.0));
  import_->add_option("--lap", lap_, "Take this lap of a recording, from 1, instead of the mean of all")
      ->type_name("N")
      ->check(whole_number(1, 1000));
  auto* open = import_->add_flag("--open", open_, "Start and finish are apart, as in an autocross");
  import_->add_flag("--closed", closed_, "Close the course, however far its ends are apart")->excludes(open);
  import_->add_flag("--reverse", reversed_, "Drive it the other way round");
  import_->add_flag("--mirror", mirrored_, "Exchange left and right (y that points down, as in pictures)");
  import_->add_option("--name", name_, "Of the course; else that of the source")->check(some_name("a name"));
  add_output_file(*import_, "--plot", plot_, "Draw course and points from above as an SVG picture");
  add_output_file(*import_, "--json", json_, "Write what is printed as JSON; -: to standard output");
  import_->footer(
      "Columns, by kind (units as x_m, x_ft, \"X [m]\", or --unit):\n"
      "  points     x, y | easting, northing | two columns without a header\n"
      "  gps        lat, lon | latitude, longitude | a GPX track\n"
      "  gates      left_x, left_y, right_x, right_y | out_x, out_y, in_x, in_y\n"
      "  curvature  s_m, curvature_1pm\n"
      "  segments   type, section_length_m, corner_radius_m | straight_m, corner_radius_m, corner_angle_rad\n"
      "Example: voltlap track import laps.gpx --out course.csv && voltlap lap --track course.csv");
}

void TrackCommand::add_show() {
  show_ = command_->add_subcommand("show", "Length, corners, tightest radius and gap of a course");
  show_->add_option("track", track_, "Name of a track (voltlap list tracks) or a CSV file")->required();
  add_output_file(*show_, "--plot", plot_, "Draw the course from above as an SVG picture");
  add_output_file(*show_, "--json", json_, "Write what is printed as JSON; -: to standard output");
}

int TrackCommand::run(const DataFolder& data) { return import_->parsed() ? import() : show(data); }

ImportOptions TrackCommand::import_options() const {
  ImportOptions options;
  if (!kind_.empty()) options.source.kind = source_kind_of(kind_);
  if (!unit_.empty()) options.source.metres_per_unit = unit_ == "ft" ? kMetresPerFoot : 1.0;
  if (open_) options.closure = Closure::kOpen;
  if (closed_) options.closure = Closure::kClosed;
  options.noise_m = noise_m_;
  options.reversed = reversed_;
  options.mirrored = mirrored_;
  if (lap_ > 0) options.lap = lap_;
  options.name = name_;
  return options;
}

std::string TrackCommand::file_head(const ImportedCourse& course) const {
  std::string head = fmt::format("# {}: made by voltlap track import from {} ({}, {} rows).\n", course.track.name,
                                 std::filesystem::path(source_).filename().string(), name_of(course.kind),
                                 course.points);
  if (course.noise_m) head += fmt::format("# Noise of the points across the course: {:.3f} m.\n", *course.noise_m);
  return head + "# Lengths and radii in metres.\n";
}

int TrackCommand::import() const {
  refuse_shared_files({{"--out", out_}, {"--plot", plot_}, {"--json", json_}});
  std::optional<AtomicFile> out = output(out_), plot = output(plot_), json = output(json_);
  ProgressLine progress("importing");
  ImportOptions options = import_options();
  options.progress = [&](const std::string& what, double fraction) { progress.show(what, fraction); };
  const ImportedCourse course = import_course(source_, options);
  progress.end();
  const CourseSummary sum = summarise(course.track);
  out->write(course_file_text(course.track, file_head(course)));
  if (plot) {
    plot->write(course_picture(course.track, course.line, course.source_points, caption(course.track, sum)));
  }
  if (json) json->write(json_of(course, sum).dump(2) + '\n');
  commit_all({&out, &plot, &json});
  fmt::print(summary_stream({out_, plot_, json_}), "{}, from {}\n{}{}", course.track.name, name_of(course.kind),
             origin_text(course), summary_text(sum, course.track.segments.size()));
  return kExitOk;
}

int TrackCommand::show(const DataFolder& data) const {
  refuse_shared_files({{"--plot", plot_}, {"--json", json_}});
  const Track track = load_track(data.find("tracks", track_, "track"));
  std::optional<AtomicFile> plot = output(plot_), json = output(json_);
  const CourseSummary sum = summarise(track);
  if (plot) {
    plot->write(course_picture(track, {}, {}, caption(track, sum)));
  }
  if (json) json->write(json_of(track, sum).dump(2) + '\n');
  commit_all({&plot, &json});
  fmt::print(summary_stream({plot_, json_}), "{}\n{}", track.name, summary_text(sum, track.segments.size()));
  return kExitOk;
}

}  // namespace voltlap::plant
