// SPDX-License-Identifier: Apache-2.0
#include "port/host/send_all.hpp"

#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap::port;

TEST_GROUP(SendAll) {
  std::vector<int> answers;  ///< frames taken, or minus the error
  std::vector<unsigned> asked;
  int waits = 0;

  SendOutcome send(unsigned count) {
    std::size_t next = 0;
    return send_all(
        count,
        [&](unsigned first) {
          asked.push_back(first);
          const int answer = answers[next < answers.size() ? next++ : answers.size() - 1];
          if (answer < 0) errno = -answer;
          return answer < 0 ? -1 : answer;
        },
        [&] { ++waits; });
  }
};

TEST(SendAll, OneCallIsEnoughWhenAllFit) {
  answers = {20};
  const SendOutcome out = send(20);
  LONGS_EQUAL(20, out.sent);
  LONGS_EQUAL(0, out.retries + out.error + waits);
  LONGS_EQUAL(1, asked.size());
}

TEST(SendAll, FullQueueIsWaitedForAndTheRestGoesOutInOrder) {
  answers = {8, -ENOBUFS, -ENOBUFS, 10, -EAGAIN, 2};
  const SendOutcome out = send(20);
  LONGS_EQUAL(20, out.sent);
  LONGS_EQUAL(0, out.error);
  LONGS_EQUAL(3, out.retries);
  LONGS_EQUAL(3, waits);
  const std::vector<unsigned> expected = {0, 8, 8, 8, 18, 18};
  CHECK(expected == asked);
}

TEST(SendAll, QueueThatStaysFullEndsAfterABoundedNumberOfWaits) {
  answers = {5, -ENOBUFS};
  const SendOutcome out = send(20);
  LONGS_EQUAL(5, out.sent);
  LONGS_EQUAL(ENOBUFS, out.error);
  LONGS_EQUAL(kSendRetriesMax, out.retries);
  LONGS_EQUAL(kSendRetriesMax, waits);
  CHECK(kSendRetriesMax * kSendRetryWait_us <= 100'000);
}

TEST(SendAll, SignalIsNoReasonToWait) {
  answers = {-EINTR, -EINTR, 3};
  const SendOutcome out = send(3);
  LONGS_EQUAL(3, out.sent);
  LONGS_EQUAL(0, waits);
}

TEST(SendAll, AnyOtherErrorEndsAtOnce) {
  for (const int error : {ENETDOWN, ENODEV, EPERM}) {
    asked.clear();
    answers = {2, -error};
    const SendOutcome out = send(9);
    LONGS_EQUAL(2, out.sent);
    LONGS_EQUAL(error, out.error);
    LONGS_EQUAL(2, asked.size());
  }
}

TEST(SendAll, NothingToSendIsNoCall) {
  LONGS_EQUAL(0, send(0).sent);
  CHECK(asked.empty());
}
