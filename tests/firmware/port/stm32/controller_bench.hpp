// SPDX-License-Identifier: Apache-2.0
// What both CAN controllers have to do alike, before whichever fake of their registers. A part says how its fake is
// wired: types Fake, Driver, Config; config(), make(fake), and take_interrupts(fake, driver), which calls what the
// vector table would.
#pragma once
#include <CppUTest/TestHarness.h>

#include <array>
#include <vector>

#include "can_dbc/tables.hpp"
#include "fake_registers.hpp"
#include "frames.hpp"
#include "port/stm32/can_controller.hpp"

namespace voltlap::port::stm32::test {

template <class Part>
class ControllerBench : public Utest {
 public:
  typename Part::Fake fake;
  Attached attached{&fake.block, sizeof fake.block, fake};
  typename Part::Driver can = Part::make(fake);
  typename Part::Driver::Config config = Part::config();

  template <std::size_t N>
  CanError init(const can::MessageRow (&rows)[N]) { return can.init(config, rows, N); }
  void start() { CHECK(init(can::kMasterRx) == CanError::kNone); }

  /// The interrupts as the vector table would take them, until the bus is idle.
  std::vector<Frame> run_bus() {
    std::vector<Frame> out;
    for (int i = 0; i < 200; ++i) {
      const auto frame = fake.transmit_one();
      if (!frame) break;
      out.push_back(*frame);
      Part::take_interrupts(fake, can);
    }
    return out;
  }
  void arrive(const Frame& frame) {
    CHECK(fake.arrive(frame));
    CHECK(Part::take_interrupts(fake, can));
  }
  bool next_step(const TxQueue& frames) {
    Frame none;
    can.receive(&none, 0);
    return can.send(frames);
  }
  std::vector<Frame> received() {
    std::vector<Frame> out(200);
    out.resize(can.receive(out.data(), out.size()));
    return out;
  }

  void frames_arrive_byte_for_byte_in_their_order() {
    start();
    std::vector<Frame> sent;
    std::uint8_t mark = 0;
    for (const std::uint8_t dlc : std::array<std::uint8_t, 5>{8, 0, 1, 5, 7}) {
      sent.push_back(frame_of(0x0B0 + mark % 5U, mark, dlc));
      arrive(sent.back());
      ++mark;
    }
    const auto got = received();
    LONGS_EQUAL(sent.size(), got.size());
    for (std::size_t i = 0; i < sent.size(); ++i) check_same(sent[i], got[i]);
    LONGS_EQUAL(0, received().size());
  }

  void bytes_beyond_the_length_are_zero_whatever_the_mailbox_holds() {
    start();
    Frame f = frame_of(0x0B0, 3, 8);
    f.dlc = 3;  // the wire carries three; the registers keep what stood in them
    arrive(f);
    const auto got = received();
    LONGS_EQUAL(0, got[0].data[3] | got[0].data[7]);
  }

  void twenty_four_frames_go_out_in_the_order_of_the_queue_through_three_mailboxes() {
    start();
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < TxQueue::kCapacity; ++i) {
      ids.push_back(i % 5 == 4 ? Frame::kExtendedFlag | 0x1806E5F4U : 0x700U - 13U * i);  // later ones more urgent
    }
    const TxQueue queue = queue_of(ids);
    CHECK(can.send(queue));
    const auto out = run_bus();
    LONGS_EQUAL(queue.size(), out.size());
    for (std::size_t i = 0; i < out.size(); ++i) check_same(queue[i], out[i]);
    LONGS_EQUAL(24, can.counts().sent);
    LONGS_EQUAL(0, can.counts().dropped);
  }

  void what_is_older_than_a_step_never_goes_out() {
    start();
    CHECK(can.send(queue_of(std::array<std::uint32_t, 5>{0x10, 0x11, 0x12, 0x13, 0x14})));
    check_same(frame_of(0x10, 0), *fake.transmit_one());  // the bus carries one, and is taken then
    CHECK(!next_step(queue_of(std::array<std::uint32_t, 2>{0x20, 0x21})));
    const auto out = run_bus();
    LONGS_EQUAL(2, out.size());
    check_same(frame_of(0x20, 0), out[0]);
    check_same(frame_of(0x21, 1), out[1]);
    LONGS_EQUAL(4, can.counts().dropped);
    CHECK(next_step(TxQueue{}));
  }

  void a_fifo_that_runs_over_is_counted_and_keeps_the_oldest() {
    start();
    for (std::uint8_t i = 0; i < 5; ++i) CHECK(fake.arrive(frame_of(0x0B0, i)));
    Part::take_interrupts(fake, can);
    LONGS_EQUAL(1, can.counts().overruns);
    const auto got = received();
    LONGS_EQUAL(3, got.size());
    for (std::uint8_t i = 0; i < 3; ++i) check_same(frame_of(0x0B0, i), got[i]);
    arrive(frame_of(0x0B0, 6));
    LONGS_EQUAL(1, can.counts().overruns);
  }

  void an_inbox_that_nobody_empties_is_counted_and_keeps_the_oldest() {
    start();
    for (std::uint8_t i = 0; i < 130; ++i) arrive(frame_of(0x0B0, i));
    LONGS_EQUAL(2, can.counts().inbox_full);
    const auto got = received();
    LONGS_EQUAL(128, got.size());
    check_same(frame_of(0x0B0, 0), got[0]);
  }

  void a_node_takes_as_many_as_it_has_room_for() {
    start();
    for (std::uint8_t i = 0; i < 5; ++i) arrive(frame_of(0x0B0, i));
    Frame two[2];
    LONGS_EQUAL(2, can.receive(two, 2));
    LONGS_EQUAL(3, received().size());
  }

  void sending_before_it_is_up_is_refused() {
    CHECK(!can.send(queue_of(std::array<std::uint32_t, 1>{0x10})));
    CHECK(can.send(TxQueue{}));
  }

  void two_nodes_on_one_board_send_in_one_step() {
    start();
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < TxQueue::kCapacity; ++i) ids.push_back(0x100 + i);
    CHECK(next_step(queue_of(ids)));
    CHECK(can.send(queue_of(ids)));
    LONGS_EQUAL(2 * TxQueue::kCapacity, run_bus().size());
    LONGS_EQUAL(0, can.counts().dropped);
  }

  void exactly_the_identifiers_of_the_table_are_passed() {
    CHECK(init(can::kBmsRx) == CanError::kNone);
    std::size_t passed = 0;
    for (std::uint32_t id = 0; id < 0x800; ++id) {
      bool wanted = false;
      for (const can::MessageRow& row : can::kBmsRx) wanted = wanted || row.id == id;
      CHECK_EQUAL(wanted, fake.arrive(frame_of(id)));
      CHECK(!fake.arrive(frame_of(id), true));                             // a remote frame of it
      CHECK(!fake.arrive(frame_of(Frame::kExtendedFlag | id)));            // an extended one with its bits low,
      CHECK(!fake.arrive(frame_of(Frame::kExtendedFlag | id << 18)));      // and high
      Part::take_interrupts(fake, can);
      if (wanted) ++passed;
      if (passed % 64 == 63) received();
    }
    for (const can::MessageRow& row : can::kBmsRx) {
      if ((row.id & Frame::kExtendedFlag) == 0) continue;
      arrive(frame_of(row.id));
      ++passed;
      CHECK(!fake.arrive(frame_of(row.id ^ 1U)));
      CHECK(!fake.arrive(frame_of(row.id & 0x7FFU)));
    }
    LONGS_EQUAL(sizeof can::kBmsRx / sizeof can::kBmsRx[0], passed);
    LONGS_EQUAL(passed, can.counts().received);
  }
};

/// The tests of a group whose base is a ControllerBench.
#define VOLTLAP_CONTROLLER_TESTS(group) \
  TEST(group, FramesArriveByteForByteInTheirOrder) { frames_arrive_byte_for_byte_in_their_order(); } \
  TEST(group, BytesBeyondTheLengthAreZeroWhateverTheMailboxHolds) { \
    bytes_beyond_the_length_are_zero_whatever_the_mailbox_holds(); \
  } \
  TEST(group, TwentyFourFramesGoOutInTheOrderOfTheQueueThroughThreeMailboxes) { \
    twenty_four_frames_go_out_in_the_order_of_the_queue_through_three_mailboxes(); \
  } \
  TEST(group, WhatIsOlderThanAStepNeverGoesOut) { what_is_older_than_a_step_never_goes_out(); } \
  TEST(group, AFifoThatRunsOverIsCountedAndKeepsTheOldest) { \
    a_fifo_that_runs_over_is_counted_and_keeps_the_oldest(); \
  } \
  TEST(group, AnInboxThatNobodyEmptiesIsCountedAndKeepsTheOldest) { \
    an_inbox_that_nobody_empties_is_counted_and_keeps_the_oldest(); \
  } \
  TEST(group, ANodeTakesAsManyAsItHasRoomFor) { a_node_takes_as_many_as_it_has_room_for(); } \
  TEST(group, SendingBeforeItIsUpIsRefused) { sending_before_it_is_up_is_refused(); } \
  TEST(group, TwoNodesOnOneBoardSendInOneStep) { two_nodes_on_one_board_send_in_one_step(); } \
  TEST(group, ExactlyTheIdentifiersOfTheTableArePassed) { exactly_the_identifiers_of_the_table_are_passed(); }

}  // namespace voltlap::port::stm32::test
