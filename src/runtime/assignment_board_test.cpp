#include "runtime/assignment_board.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

TEST(AssignmentBoard, KeepsWhatAReaderMayLookAtAndNoMore) {
  AssignmentBoard board(2);
  for (int i = 0; i < 5; ++i) board.publish({});
  EXPECT_EQ(board.kept(), 5U) << "no controller has looked";
  EXPECT_EQ(board.read(0).number, 5U);
  board.publish({});
  EXPECT_EQ(board.kept(), 6U) << "the other has not";
  EXPECT_EQ(board.read(1).number, 6U);
  board.publish({});
  EXPECT_EQ(board.kept(), 3U);
}

// Guards: where a controller has no thread, all assignments were kept for good.
TEST(AssignmentBoard, DoesNotWaitForAReaderThatNeverLooks) {
  AssignmentBoard board(2);
  board.leave_out(1);
  for (int i = 0; i < 100; ++i) {
    board.publish({});
    board.read(0);
  }
  EXPECT_LE(board.kept(), 2U);
}

}  // namespace
}  // namespace ctn::runtime
