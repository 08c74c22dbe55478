#include "server/net/byte_account.h"

#include <gtest/gtest.h>

#include "server/net/stranger_rations.h"

namespace curvd {
namespace {

using Verdict = ByteAccount::Verdict;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr ByteAllowances kAllowances = {100'000, 300'000, 5'000'000, 8'192};
constexpr ByteAccount::Clock::time_point kStart{};

class ByteAccountTest : public ::testing::Test {
 protected:
  // The server answers nothing but `sent` bytes.
  Verdict JudgeAt(uint64_t read, ByteAccount::Clock::duration after, uint64_t sent = 0) {
    return account_.Judge(read, sent, kStart + after);
  }

  ByteAccount account_{kAllowances, kStart};
};

TEST_F(ByteAccountTest, AStrangerMaySendAHandshakeAndACall) {
  EXPECT_EQ(JudgeAt(0, seconds(0)), Verdict::kFine);
  EXPECT_EQ(JudgeAt(90'000, seconds(0)), Verdict::kOwes);
  EXPECT_EQ(account_.unaccounted(), 90'000u);
  EXPECT_EQ(account_.accounted(), 0u);
}

TEST_F(ByteAccountTest, WhoHasUsedUpWhatStrangersMaySendIsGivenTimeToBeLetIn) {
  EXPECT_EQ(JudgeAt(100'000, seconds(0)), Verdict::kSuspect);
  EXPECT_EQ(JudgeAt(100'000, ByteAccount::kPatience), Verdict::kSuspect);
  account_.NoteLetIn();
  EXPECT_EQ(JudgeAt(100'000, 10 * ByteAccount::kPatience), Verdict::kFine);
}

TEST_F(ByteAccountTest, ASuspectOfWhomNoCallIsLetInHasSentTooMuch) {
  EXPECT_EQ(JudgeAt(100'000, seconds(0)), Verdict::kSuspect);
  EXPECT_EQ(JudgeAt(100'000, ByteAccount::kPatience + milliseconds(1)), Verdict::kTooMuch);
}

// The system moves its bound in steps, so that a stranger may be held back right below it.
TEST_F(ByteAccountTest, AStrangerIsASuspectAStepBelowTheBound) {
  EXPECT_EQ(JudgeAt(100'000 - StrangerRations::kStepBytes - 1, seconds(0)), Verdict::kOwes);
  EXPECT_EQ(JudgeAt(100'000 - StrangerRations::kStepBytes, seconds(0)), Verdict::kSuspect);
}

TEST_F(ByteAccountTest, WhereTheSystemBoundsNothingAStrangerGetsNoTime) {
  EXPECT_EQ(JudgeAt(200'000, seconds(0)), Verdict::kSuspect);
  EXPECT_EQ(JudgeAt(200'001, seconds(0)), Verdict::kTooMuch);
}

TEST_F(ByteAccountTest, AProbeThatAsksEverySecondIsFineForDays) {
  uint64_t read = 0;
  for (int second = 0; second < 200'000; ++second) {
    read += 300;
    account_.NoteOpenToAll();
    account_.NoteAnswered(50);
    account_.NoteOpenToAllEnd();
    ASSERT_EQ(JudgeAt(read, seconds(second), read), Verdict::kFine) << second;
  }
}

// Pings are answered with as many bytes.
TEST_F(ByteAccountTest, AConnectionThatOnlyPingsIsFineForDays) {
  uint64_t read = 0;
  for (int second = 0; second < 200'000; second += 5) {
    read += 60;
    ASSERT_EQ(JudgeAt(read, seconds(second), read), Verdict::kFine) << second;
  }
}

// 9.6 kbit/s carry 960 bytes a second with what TCP adds. A handshake with certificates, and all the metadata that a
// call may have.
TEST_F(ByteAccountTest, ACallerOnASlowLineIsLetIn) {
  constexpr uint64_t kHandshake = 10'000;
  uint64_t read = 0;
  int second = 0;
  for (; read < kHandshake + kAllowances.max_metadata; ++second) {
    read += 960;
    ASSERT_NE(JudgeAt(read, seconds(second), read < kHandshake ? 0 : 4'000), Verdict::kTooMuch) << second;
  }
  account_.NoteLetIn();
  EXPECT_EQ(JudgeAt(read, seconds(second + 3'600)), Verdict::kFine);
}

// As slow as pings, which are answered.
TEST_F(ByteAccountTest, AHeaderThatDripsInIsNotForgiven) {
  uint64_t read = 0;
  int second = 0;
  Verdict verdict = Verdict::kFine;
  for (; second < 1'000 && verdict != Verdict::kTooMuch; ++second) {
    read += 60;
    verdict = JudgeAt(read, seconds(second), 150);  // SETTINGS
  }
  EXPECT_EQ(verdict, Verdict::kTooMuch);
  EXPECT_GT(read, ByteAccount::kSmallBytes);
  EXPECT_LT(read, ByteAccount::kSmallBytes + 100 * static_cast<uint64_t>(kAllowances.patience().count()));
}

TEST_F(ByteAccountTest, MoreThanAHandshakeHasToBeAnsweredInTime) {
  const seconds patience = kAllowances.patience();
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes, seconds(0)), Verdict::kFine);
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 1, seconds(1)), Verdict::kOwes);
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 1, seconds(1) + patience), Verdict::kOwes);
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 1, seconds(1) + patience + milliseconds(1)), Verdict::kTooMuch);
}

TEST_F(ByteAccountTest, WhoseCallsAreAnsweredInTimeOwesNothing) {
  const seconds patience = kAllowances.patience();
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 1'000, seconds(1)), Verdict::kOwes);
  account_.NoteAnswered(1'000);
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 1'000, seconds(2)), Verdict::kFine);
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 3'000, 2 * patience), Verdict::kOwes);
  EXPECT_EQ(JudgeAt(ByteAccount::kSmallBytes + 3'000, 3 * patience), Verdict::kOwes);
}

TEST_F(ByteAccountTest, PatienceGrowsWithTheMetadataThatACallMayHave) {
  EXPECT_EQ(ByteAllowances().patience(), seconds(26));
  EXPECT_EQ((ByteAllowances{1 << 20, 1 << 20, 1 << 20, 1 << 20}.patience()), seconds(10 + 2'048));
}

// gRPC holds 17 KiB for each.
TEST_F(ByteAccountTest, OpenCallsThatEverybodyMayMakeCountForMoreThanTheirBytes) {
  for (int call = 0; call < 400; ++call) account_.NoteOpenToAll();
  EXPECT_EQ(JudgeAt(1'000, seconds(0)), Verdict::kSuspect);
  for (int call = 0; call < 500; ++call) account_.NoteOpenToAllEnd();
  EXPECT_EQ(JudgeAt(1'000, seconds(0)), Verdict::kFine);
  EXPECT_EQ(account_.unaccounted(), 1'000u);
}

TEST_F(ByteAccountTest, CreditOfAnswersIsNotSavedUp) {
  for (int i = 0; i < 1'000; ++i) account_.NoteAnswered(8'000);
  EXPECT_EQ(JudgeAt(1'000, seconds(0)), Verdict::kFine);
  EXPECT_EQ(account_.accounted(), 1'000u);
  EXPECT_EQ(JudgeAt(201'001 + 1'000, seconds(0)), Verdict::kTooMuch);
}

// Metadata of 8,000 bytes may take a few when HTTP/2 has packed it.
TEST_F(ByteAccountTest, AnAnswerAccountsForLittleBesideItsCall) {
  EXPECT_EQ(JudgeAt(90'000, seconds(0)), Verdict::kOwes);
  for (int i = 0; i < 10; ++i) account_.NoteAnswered(8'000);
  EXPECT_EQ(JudgeAt(90'000, seconds(0)), Verdict::kOwes);
  EXPECT_GE(account_.unaccounted(), 75'000u);
}

// As a client does that downloads for days: 13 bytes for the stream and for the connection, for each frame of 16 KiB,
// in a record of TLS.
TEST_F(ByteAccountTest, UpdatesOfWindowsAreAccountedForByWhatWasSent) {
  account_.NoteLetIn();
  account_.NoteMessage(100, true);
  constexpr uint64_t kFrame = 16 << 10, kFrames = 45;
  uint64_t read = 1'000;
  for (int message = 0; message < 1'000'000; ++message) {
    account_.NoteSent(kFrames * kFrame);
    read += kFrames * (2 * 13 + 29);
    ASSERT_EQ(JudgeAt(read, seconds(0)), Verdict::kFine) << message;
  }
  EXPECT_LT(account_.unaccounted(), 1'000u);
}

// Its end comes after another connection of the same peer has begun.
TEST_F(ByteAccountTest, TheEndOfACallThatIsNotOpenChangesNothing) {
  account_.NoteLetIn();
  EXPECT_EQ(JudgeAt(200'000, seconds(0)), Verdict::kFine);
  account_.NoteEnd({});
  const uint64_t allowance = account_.allowance();
  JudgeAt(200'000, seconds(0));
  const uint64_t unaccounted = account_.unaccounted();
  for (int i = 0; i < 3; ++i) account_.NoteEnd({.metadata = 100, .messages = 1});
  EXPECT_EQ(account_.allowance(), allowance);
  JudgeAt(200'000, seconds(0));
  EXPECT_EQ(account_.unaccounted(), unaccounted);
}

TEST_F(ByteAccountTest, TheEndOfACallWhoseMessagesCameByAnotherConnectionTakesNoMemoryFromOthers) {
  account_.NoteLetIn();
  account_.NoteLetIn();
  const uint64_t allowance = account_.allowance();
  account_.NoteEnd({.metadata = 100, .messages = 1});
  EXPECT_LT(account_.allowance(), allowance);
}

TEST_F(ByteAccountTest, AStrangersAllowanceFollowsTheLimitOfMetadata) {
  EXPECT_EQ(ByteAllowances().stranger, 96u << 10);
  EXPECT_EQ(ByteAllowances::ForMetadata(1 << 20), (1u << 20) + (88u << 10));
  EXPECT_EQ(ByteAllowances().strangers_together(), 20u << 10);
}

TEST_F(ByteAccountTest, MessagesAccountForThemselves) {
  account_.NoteLetIn();
  account_.NoteMessage(100, true);
  uint64_t read = 10'000;
  for (int chunk = 0; chunk < 1'000; ++chunk) {
    read += 5'020'000;  // with frames of HTTP/2 and records of TLS
    account_.NoteMessage(5'000'000, false);
    ASSERT_EQ(JudgeAt(read, seconds(0)), Verdict::kFine) << chunk;
  }
}

TEST_F(ByteAccountTest, AMessageThatIsNotCompleteCountsForEachCallThatHasMemory) {
  account_.NoteLetIn();
  account_.NoteLetIn();
  const uint64_t headers_only = account_.allowance();
  account_.NoteMessage(100, true);
  account_.NoteMessage(100, true);
  const uint64_t allowance = headers_only + 2 * kAllowances.max_message + ByteAccount::kOversizedBytes;
  EXPECT_EQ(account_.allowance(), allowance);
  EXPECT_EQ(JudgeAt(allowance, seconds(0)), Verdict::kFine);
  EXPECT_EQ(JudgeAt(allowance + 10'000, seconds(0)), Verdict::kTooMuch);
}

TEST_F(ByteAccountTest, ACallWhoseFirstMessageNeverEndsGetsLittle) {
  for (int call = 0; call < 200; ++call) account_.NoteLetIn();
  EXPECT_EQ(JudgeAt(14'000'000, seconds(0)), Verdict::kFine);
  EXPECT_EQ(JudgeAt(16'000'000, seconds(0)), Verdict::kTooMuch);
}

TEST_F(ByteAccountTest, WhatWasOnItsWayToACallThatFailedIsFine) {
  uint64_t read = 0;
  for (int call = 0; call < 1'000; ++call) {
    account_.NoteLetIn();
    account_.NoteMessage(100, true);
    account_.NoteEnd({.metadata = 300, .messages = 1, .broken_off = call % 2 == 0});
    read += 4'000'000;  // after the end
    ASSERT_EQ(JudgeAt(read, seconds(0)), Verdict::kFine) << call;
  }
}

TEST_F(ByteAccountTest, ManySmallCallsAreFineForHours) {
  uint64_t read = 0;
  for (int call = 0; call < 1'000'000; ++call) {
    account_.NoteLetIn();
    account_.NoteMessage(20, true);
    account_.NoteEnd({.metadata = 8'000, .messages = 1});
    read += 8'500;
    ASSERT_EQ(JudgeAt(read, milliseconds(call)), Verdict::kFine) << call;
  }
}

TEST_F(ByteAccountTest, CallsThatAreBrokenOffAtOnceAreBounded) {
  uint64_t read = 0;
  Verdict verdict = Verdict::kFine;
  int calls = 0;
  for (; calls < 100'000 && verdict == Verdict::kFine; ++calls) {
    account_.NoteLetIn();
    account_.NoteEnd({.metadata = 300, .broken_off = true});
    read += 100;
    verdict = JudgeAt(read, seconds(0));
  }
  EXPECT_EQ(verdict, Verdict::kTooMuch);
  EXPECT_GT(calls, 2'000);
}

TEST_F(ByteAccountTest, SomeCallsASecondMayBeBrokenOffForHours) {
  uint64_t read = 0;
  for (int second = 0; second < 20'000; ++second) {
    for (int call = 0; call < 20; ++call) {
      account_.NoteLetIn();
      account_.NoteEnd({.metadata = 300, .broken_off = true});
    }
    read += 20 * 150;
    ASSERT_EQ(JudgeAt(read, seconds(second)), Verdict::kFine) << second;
  }
}

TEST_F(ByteAccountTest, MetadataBeyondTwiceTheLimitShowsThatTheLimitDidNotHold) {
  EXPECT_FALSE(account_.TooMuchMetadata(2 * kAllowances.max_metadata));
  EXPECT_TRUE(account_.TooMuchMetadata(2 * kAllowances.max_metadata + 1));
}

}  // namespace
}  // namespace curvd
