// Files that tests of the detector chain write, and those that they may be given.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "detector/film.h"

namespace ctn::navigation::testing {

// A file of this test alone.
inline std::string own_file(const std::string& name) {
  const ::testing::TestInfo* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  return ::testing::TempDir() + test->test_suite_name() + "." + test->name() + "." + name;
}

inline std::string written(const std::string& name, std::string_view contents) {
  std::string path = own_file(name);
  std::ofstream(path, std::ios::binary) << contents;
  return path;
}

inline EncodedPicture picture_in(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline const Film& debian_film() {
  static const Result<Film> kFilm = Film::open();
  if (!kFilm) {
    ADD_FAILURE() << kFilm.error().message();
    std::abort();
  }
  return *kFilm;
}

// The folder with a real network and pictures, in the environment's CATAN_YOLO; empty if it is not given.
inline std::string network_folder() {
  const char* const folder = std::getenv("CATAN_YOLO");
  return folder == nullptr ? "" : folder;
}

}  // namespace ctn::navigation::testing

// In a test's body: what needs a real network, which is no part of the product.
#define CATAN_NEEDS_NETWORK()                                                                             \
  do {                                                                                                    \
    if (ctn::navigation::testing::network_folder().empty()) {                                             \
      GTEST_SKIP() << "needs a network: set CATAN_YOLO to a folder with yolo-fastest-1.1.cfg, .weights, " \
                      "coco.names, dog.jpg and person.jpg";                                               \
    }                                                                                                     \
  } while (false)
