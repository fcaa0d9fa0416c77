// SPDX-License-Identifier: Apache-2.0
#include "apps/lap_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "io/atomic_file.hpp"
#include "race/track/outline.hpp"

namespace voltlap::plant {

LapCommand::LapCommand(CLI::App& app)
    : command_(app.add_subcommand("lap", "Fastest lap of a car on a track, from the lap solver alone")) {
  car_.add_vehicle(*command_);
  car_.add_track(*command_);
  car_.add_lap_start(*command_);
  add_output_file(*command_, "--json", json_,
                  "Write lap_time_s, max_speed_mps, length_m and closing_gap_m as JSON; -: to standard output, "
                  "the summary then to standard error");
  command_->footer("Example: voltlap lap --track michigan_2014 --lap-start standing");
}

int LapCommand::run(const DataFolder& data) {
  const VehicleParameters car = car_.load_car(data).parameters;
  const Track track = car_.load_course(data);
  std::optional<AtomicFile> json;
  if (!json_.empty()) json.emplace(json_);
  const SpeedProfile lap = solve_lap(car, track, car_.start());
  const double gap_m = closing_gap_m(track);
  if (json) {
    json->write(fmt::format(
        "{{\n  \"lap_time_s\": {},\n  \"max_speed_mps\": {},\n  \"length_m\": {},\n  \"closing_gap_m\": {}\n}}\n",
        lap.lap_time_s(), lap.max_speed_mps(), lap.length_m(), gap_m));
    json->commit();
  }
  fmt::print(summary_stream({json_}),
             "{} on {}, {} lap\n  lap time   {:8.2f} s\n  top speed  {:8.2f} m/s\n  course: {}\n", car.name, track.name,
             car_.lap_start, lap.lap_time_s(), lap.max_speed_mps(), course_text(lap.length_m(), gap_m));
  return kExitOk;
}

}  // namespace voltlap::plant
