// SPDX-License-Identifier: Apache-2.0
#include "io/bus/trace_hash.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

Frame frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  Frame f;
  f.id = id;
  for (const std::uint8_t byte : bytes) f.data[f.dlc++] = byte;
  return f;
}

TraceHash::Result hash_of(std::uint32_t tick, Sender sender, const Frame& f) {
  TraceHash hash;
  hash.on_frame(tick, sender, f);
  return hash.finish();
}

}  // namespace

TEST_GROUP(TraceHash) {};

TEST(TraceHash, Sha256OfAbcIsTheOneOfTheStandard) {
  Sha256 hash;
  const std::uint8_t abc[] = {'a', 'b', 'c'};
  hash.add(abc, sizeof abc);
  STRCMP_EQUAL("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", hash.finish().c_str());
}

TEST(TraceHash, Sha256OfAMillionLettersIsTheOneOfTheStandard) {
  Sha256 hash;
  const std::uint8_t letter = 'a';
  for (int i = 0; i < 1'000'000; ++i) hash.add(&letter, 1);
  STRCMP_EQUAL("cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0", hash.finish().c_str());
}

TEST(TraceHash, RecordIsTickSenderIdLengthAndDataInLittleEndian) {
  const std::uint8_t record[] = {0x04, 0x03, 0x02, 0x01, 2, 0x56, 0x34, 0x12, 0x80, 2, 0xAA, 0xBB};
  Sha256 by_hand;
  by_hand.add(record, sizeof record);
  STRCMP_EQUAL(by_hand.finish().c_str(),
               hash_of(0x01020304, Sender::kMaster, frame(0x80123456, {0xAA, 0xBB})).trace.c_str());
}

TEST(TraceHash, NodesHaveTheirOwnHashes) {
  const TraceHash::Result r = hash_of(1, Sender::kBms, frame(0x0C0, {1}));
  STRCMP_EQUAL(r.trace.c_str(), r.bms.c_str());
  STRCMP_EQUAL(r.plant.c_str(), r.master.c_str());  // both of nothing
  CHECK(r.plant != r.bms);
}

TEST(TraceHash, EachFieldOfAFrameCounts) {
  const std::string first = hash_of(1, Sender::kPlant, frame(0x0B0, {1, 2})).trace;
  CHECK(first != hash_of(2, Sender::kPlant, frame(0x0B0, {1, 2})).trace);
  CHECK(first != hash_of(1, Sender::kBms, frame(0x0B0, {1, 2})).trace);
  CHECK(first != hash_of(1, Sender::kPlant, frame(0x0B1, {1, 2})).trace);
  CHECK(first != hash_of(1, Sender::kPlant, frame(0x0B0, {1})).trace);
  CHECK(first != hash_of(1, Sender::kPlant, frame(0x0B0, {1, 3})).trace);
}
