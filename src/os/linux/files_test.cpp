#include "os/linux/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "os/linux/testing/fabricated_tree.h"

namespace ctn::os {
namespace {

TEST(Files, LineIsTheFirstWithoutBlanks) {
  FabricatedTree tree;
  tree.write("sys/a", "  performance \nmore\n")
      .write("sys/empty", "")
      .write("sys/blank", " \n")
      .write("sys/n", std::string("Pi\0", 3));
  const std::string sysfs = tree.roots().sysfs;
  EXPECT_EQ(read_line(sysfs + "/a"), "performance");
  EXPECT_EQ(read_line(sysfs + "/n"), "Pi");
  EXPECT_EQ(read_line(sysfs + "/empty"), std::nullopt);
  EXPECT_EQ(read_line(sysfs + "/blank"), std::nullopt);
  EXPECT_EQ(read_line(sysfs + "/missing"), std::nullopt);
  EXPECT_EQ(read_line(sysfs), std::nullopt);  // a folder
}

TEST(Files, IntegerIsNothingButOne) {
  FabricatedTree tree;
  const std::string file = tree.roots().sysfs + "/n";
  for (const auto& [content, number] :
       std::vector<std::pair<std::string, std::optional<std::int64_t>>>{{"42\n", 42},
                                                                        {"-1\n", -1},
                                                                        {"42 kHz", std::nullopt},
                                                                        {"99999999999999999999", std::nullopt},
                                                                        {"", std::nullopt},
                                                                        {"0x10", std::nullopt}}) {
    tree.write("sys/n", content);
    EXPECT_EQ(read_integer(file), number) << content;
  }
}

TEST(Files, ValuesOfKeys) {
  const std::string text = "processor\t: 0\nmodel name\t:  Cortex : A72 \nempty\t:\nempty : full";
  EXPECT_EQ(find_value(text, "model name"), "Cortex : A72");
  EXPECT_EQ(find_value(text, "empty"), "full");
  EXPECT_EQ(find_value(text, "model"), std::nullopt);
  EXPECT_EQ(find_value("", "model"), std::nullopt);
}

TEST(Files, NumberedEntriesLeaveOutTheOthers) {
  FabricatedTree tree;
  for (const char* name : {"cpu10/x", "cpu2/x", "cpu/x", "cpufreq/x", "cpu-1/x", "cpu99999999999/x", "xcpu1/x"}) {
    tree.write(std::string("sys/") + name, "");
  }
  EXPECT_EQ(numbered_entries(tree.roots().sysfs, "cpu"), (std::vector<int>{2, 10}));
  EXPECT_EQ(numbered_entries(tree.roots().procfs, ""), std::nullopt);
}

}  // namespace
}  // namespace ctn::os
