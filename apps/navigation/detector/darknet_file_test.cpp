#include "detector/darknet_file.h"

#include <gtest/gtest.h>

namespace ctn::navigation {
namespace {

constexpr const char* kGood =
    "# a comment\n[net]\n batch = 1\nwidth=416 # pixels\nheight=320\nchannels=3\n\n"
    "[convolutional]\nfilters=255\nwidth=7\n[yolo]\nclasses=80\n[convolutional]\n[yolo]\nclasses = 80\n";

std::string with(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

// The first problem, as the user reads it.
std::string problem(const std::string& text) {
  const auto file = read_darknet(text, "my.cfg");
  if (file.ok()) return "none";
  EXPECT_EQ(file.error().kind(), ErrorKind::kCaller);
  return file.error().message();
}

TEST(DarknetFile, TellsInputAndClasses) {
  const auto file = read_darknet(kGood, "my.cfg");
  ASSERT_TRUE(file.ok()) << file.error().message();
  EXPECT_EQ(file->width, 416);
  EXPECT_EQ(file->height, 320);
  EXPECT_EQ(file->classes, 80);
}

TEST(DarknetFile, SaysInWhichLineWhatIsWrong) {
  EXPECT_EQ(problem(with(kGood, "416", "400")),
            "my.cfg:4: net.width: '400' is not possible; write a multiple of 32 from 32 to 2048");
  EXPECT_EQ(problem(with(kGood, "416", "4e2")),
            "my.cfg:4: net.width: '4e2' is not possible; write a multiple of 32 from 32 to 2048");
  EXPECT_EQ(problem(with(kGood, "=320", "=-32")),
            "my.cfg:5: net.height: '-32' is not possible; write a multiple of 32 from 32 to 2048");
  EXPECT_NE(problem(with(kGood, "channels=3", "channels=1")).find("my.cfg:6: net.channels"), std::string::npos);
  EXPECT_NE(problem(with(kGood, "classes=80", "classes=0")).find("my.cfg:12: yolo.classes"), std::string::npos);
  EXPECT_NE(problem(with(kGood, "classes=80", "classes=79")).find("my.cfg:15: yolo.classes"), std::string::npos);
}

TEST(DarknetFile, SaysWhatIsMissing) {
  EXPECT_NE(problem("").find("no section [net]"), std::string::npos);
  EXPECT_NE(problem("person\nbicycle\n").find("no section [net]"), std::string::npos);
  EXPECT_NE(problem(with(kGood, "width=416", "")).find("width or height is missing"), std::string::npos);
  EXPECT_NE(problem("[net]\nwidth=32\nheight=32\n[softmax]\n").find("detects nothing"), std::string::npos);
}

}  // namespace
}  // namespace ctn::navigation
