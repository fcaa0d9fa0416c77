// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/can_recording.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <fstream>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CanRecording) {
  Scratch scratch;
  std::vector<double> times_of(CanRecording & recording) {
    std::vector<double> out;
    RecordedFrame frame;
    while (recording.next(frame)) out.push_back(frame.time_s);
    return out;
  }
  std::vector<double> times_of(const std::string& text) {
    CanRecording recording(scratch.write("a.log", text));
    return times_of(recording);
  }
  const CanDefect* defect(const CanRecording& recording, const char* kind) {
    for (const CanDefect& found : recording.summary().defects) {
      if (found.kind == kind) return &found;
    }
    return nullptr;
  }
};

TEST(CanRecording, FourFormatsAreTold) {
  const struct {
    CanFormat format;
    const char* text;
  } files[] = {
      {CanFormat::kCandump, "(1.0) can0 044#2A36\n(1.5) can0 044#2A36\n"},
      {CanFormat::kAsc, "date x\nbase hex timestamps absolute\n 1.0 1 44 Rx d 1 00\n 1.5 1 44 Rx d 1 00\n"},
      {CanFormat::kRawHex, "000003E8x000000440108160000000000\r\n000005DCx000000440108160000000000\r\n"},
      {CanFormat::kSlcan, "t04412A03E8\nt04412A05DC\n"}};
  for (const auto& file : files) {
    CanRecording recording(scratch.write("a", file.text));
    LONGS_EQUAL(static_cast<int>(file.format), static_cast<int>(recording.format()));
    const auto times = times_of(recording);
    LONGS_EQUAL(2, times.size());
    DOUBLES_EQUAL(1.0, times[0], 1e-9);
    DOUBLES_EQUAL(1.5, times[1], 1e-9);
    CHECK(recording.summary().defects.empty());
  }
}

TEST(CanRecording, GzippedIsReadLikePlain) {
  const std::string packed = scratch.file("a.log.gz");
  gzFile out = gzopen(packed.c_str(), "wb");
  gzputs(out, "(1.0) can0 044#2A36\n(1.5) can0 044#2A36");
  gzclose(out);
  CanRecording recording(packed);
  LONGS_EQUAL(2, times_of(recording).size());
}

TEST(CanRecording, RelativeStampsAddUpAndTheStampThatWrapsGoesOn) {
  const auto relative = times_of("base hex timestamps relative\n0.5 1 44 Rx d 1 00\n0.25 1 44 Rx d 1 00\n");
  DOUBLES_EQUAL(0.75, relative[1], 1e-12);
  const auto wrapped = times_of("t04412AEA00\nt04412A0064\n");  // 59.904 s, 0.1 s
  DOUBLES_EQUAL(60.1, wrapped[1], 1e-9);
}

TEST(CanRecording, FramesOutOfOrderAreSortedAndCounted) {
  CanRecording recording(scratch.write(
      "a", "(12.900) c 044#00\n(12.996) c 044#00\n(12.001) c 044#00\n(12.002) c 044#00\n(13.0) c 044#00\n"));
  const auto times = times_of(recording);
  LONGS_EQUAL(5, times.size());
  CHECK(std::is_sorted(times.begin(), times.end()));
  DOUBLES_EQUAL(12.001, times[0], 0.0);
  const CanDefect* order = defect(recording, "out of order, sorted");
  CHECK(order != nullptr);
  CHECK(order->used);
  LONGS_EQUAL(2, order->count);
  LONGS_EQUAL(3, order->first_line);
}

TEST(CanRecording, OneFrameFarAheadDoesNotSilenceTheRest) {
  CanRecording recording(scratch.write("a", "(1.0) c 044#00\n(9999.0) c 044#00\n(1.1) c 044#00\n(1.2) c 044#00\n"));
  LONGS_EQUAL(3, times_of(recording).size());
  LONGS_EQUAL(1, defect(recording, "time far ahead of the frames around it")->count);
}

TEST(CanRecording, EveryKindOfBadLineIsCountedByItself) {
  CanRecording recording(scratch.write("a",
                                       "(1.0) c 044#00\n(1.0) c 044##100\n(1.0) c 044#R\nrubbish\n(1.1) c "
                                       "20000004#00\n(1.1) c 40000000#00\n(1.2) c 044#00"));
  LONGS_EQUAL(3, times_of(recording).size());
  for (const char* kind : {"remote frame, without data", "line that is no frame",
                           "error frame", "identifier beyond 29 bits"}) {
    CHECK_TEXT(defect(recording, kind) != nullptr, kind);
  }
  LONGS_EQUAL(4, defect(recording, "line that is no frame")->first_line);
}

TEST(CanRecording, RemoteFramesAreGivenToWhoAsksForThem) {
  const std::string path = scratch.write("a.log", "(1.0) c 044#00\n(1.1) c 18FF1234#R4\n(1.2) c 044#00\n");
  CanReading reading;
  reading.keep_remote = true;
  CanRecording recording(path, reading);
  RecordedFrame frame;
  std::vector<bool> remote;
  while (recording.next(frame)) remote.push_back(frame.remote);
  CHECK(remote == std::vector<bool>({false, true, false}));
  CHECK(recording.summary().defects.empty());
  CanRecording without(path);
  while (without.next(frame)) CHECK_FALSE(frame.remote);
  LONGS_EQUAL(1, defect(without, "remote frame, without data")->count);
}

TEST(CanRecording, HopelessFilesAreRefusedByFileAndLine) {
  STRCMP_CONTAINS("no frame in the first 1000 lines",
                  complaint([&] { times_of("time,id,len,data\n1,2,3,4\n"); }).c_str());
  STRCMP_CONTAINS("no file that can be opened",
                  complaint([&] { CanRecording absent(scratch.file("absent")); }).c_str());
  std::string mixed = "(1.0) c 044#00\n";
  for (int k = 0; k < 600; ++k) mixed += "rubbish\n";
  STRCMP_CONTAINS("a.log:502", complaint([&] { times_of(mixed); }).c_str());
}
