// SPDX-License-Identifier: Apache-2.0
// One seed is one run, frame by frame; and a recorded drive in place of a course.
#include "fixtures.hpp"
#include "loop.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

TraceHash::Result hashes(const EnduranceOptions& options) {
  Record record;
  record.hashes = true;
  static_cast<void>(drive(options, record));
  return record.hash.finish();
}

}  // namespace

TEST_GROUP(Trace) {
  EnduranceOptions options = nominal();

  void setup() override {
    options.drive = RecordedDrive{"short", {0.0, 4.0, 8.0, 10.0}, {0.0, 10.0, 10.0, 2.0}, {}, {}};
    options.representative_cell = false;
  }
};

TEST(Trace, OneSeedGivesTheSameFramesOfEveryNode) {
  options.vehicle.sensors.noise = true;
  const TraceHash::Result a = hashes(options), b = hashes(options);
  STRCMP_EQUAL(a.trace.c_str(), b.trace.c_str());
  STRCMP_EQUAL(a.plant.c_str(), b.plant.c_str());
  STRCMP_EQUAL(a.bms.c_str(), b.bms.c_str());
  STRCMP_EQUAL(a.master.c_str(), b.master.c_str());
}

TEST(Trace, AnotherSeedGivesOtherFramesOnlyWithNoise) {
  EnduranceOptions other = options;
  other.seed = options.seed + 1;
  CHECK(hashes(options).trace == hashes(other).trace);
  options.vehicle.sensors.noise = other.vehicle.sensors.noise = true;
  const TraceHash::Result a = hashes(options), b = hashes(other);
  CHECK(a.trace != b.trace);
  CHECK(a.plant != b.plant);
  CHECK(a.bms != b.bms);
}

TEST(Trace, ARecordedDriveIsFollowedOnceAndCountsAsOneLap) {
  Record record;
  const EnduranceResult r = drive(options, record);
  STRCMP_EQUAL("", r.failure_cause.c_str());
  CHECK(r.finished);
  DOUBLES_EQUAL(10.0, r.total_time_s, 1e-9);
  DOUBLES_EQUAL(options.drive->length_m(), r.distance_m, 2.0);
  LONGS_EQUAL(1, r.laps);
  LONGS_EQUAL(1, r.lap_rows.size());
  for (const TimeSample& s : record.samples) {
    if (s.time_s > 2.0) DOUBLES_EQUAL(s.target_mps, s.speed_mps, 1.0);
  }
}

TEST(Trace, ARecordedDriveWithPedalsIsDrivenToo) {
  options.drive->accelerator = {0.6, 0.3, 0.0, 0.0};
  options.drive->brake = {0.0, 0.0, 0.4, 0.0};
  const EnduranceResult r = drive(options);
  CHECK(r.finished);
  DOUBLES_EQUAL(options.drive->length_m(), r.distance_m, 2.0);
}

TEST(Trace, SamplesComeTenTimesASecondFromTheStartOfTheDrive) {
  Record record;
  static_cast<void>(drive(options, record));
  CHECK(record.samples.size() >= 99 && record.samples.size() <= 101);
  for (std::size_t i = 1; i < record.samples.size(); ++i) {
    DOUBLES_EQUAL(0.1, record.samples[i].time_s - record.samples[i - 1].time_s, 1e-9);
    CHECK(record.samples[i].distance_m >= record.samples[i - 1].distance_m);
  }
  DOUBLES_EQUAL(1.0, record.progress, 0.02);
}
