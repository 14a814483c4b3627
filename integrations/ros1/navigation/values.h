// The values that the navigation app's nodes give one another, as messages of ROS.
//
// They are sent as they are, by roscpp's traits for types that are no generated messages: nothing is converted, and
// what arrives is what was given, to the bit. Each has a definition in ROS's language, with which bags are read, and in
// place of ROS's sum one of ours, of the definition: programs that differ in it do not connect.
//
// Keyframes hold a scan each, so that a few hundred come to megabytes. They are sent to GM alone, when there are new
// ones (KeyframesMessage). GP and NC ask only where keyframes are: to them go their poses (Fix).
//
// Units: as the values. Thread safety: pure functions.
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>
#include <type_traits>
#include <vector>

#include "nodes/global_mapper.h"
#include "nodes/global_planner.h"
#include "nodes/handed_on.h"
#include "nodes/navigation_command.h"
#include "nodes/scan_filter.h"
#include "run/hardware.h"

namespace ctn::navigation::ros1 {

// All that GM takes of a localization: every keyframe, with its scan but without the scan's points.
struct KeyframesMessage {
  Localization localization;
};

// --- How a value's fields are written, read and measured: one function for all three, as roscpp has it ---

namespace fields {

namespace streams = ros::serialization::stream_types;

template <class Stream>
inline constexpr bool kReads = Stream::stream_type == streams::Input;

// As a number of ROS's type `As`.
template <class As, class Stream, class T>
void number(Stream& stream, T& value) {
  if constexpr (kReads<Stream>) {
    As as{};
    stream.next(as);
    value = static_cast<T>(as);
  } else {
    stream.next(static_cast<As>(value));
  }
}

template <class Stream, class T>
void time(Stream& stream, T& value) {
  auto count = value.count();
  number<std::int64_t>(stream, count);
  if constexpr (kReads<Stream>) value = std::chrono::nanoseconds(count);
}

// How many there are; what is read must fit into what is left of the message.
template <class Stream, class List>
void size(Stream& stream, List& list) {
  auto count = static_cast<std::uint32_t>(list.size());
  number<std::uint32_t>(stream, count);
  if constexpr (kReads<Stream>) {
    if (count > stream.getLength()) ros::serialization::throwStreamOverrun();
    list.resize(count);
  }
}

// Of numbers, which lie in a message as they do in memory.
template <class Stream, class List>
void numbers(Stream& stream, List& list) {
  size(stream, list);
  const auto bytes = static_cast<std::uint32_t>(list.size() * sizeof(list[0]));
  if constexpr (Stream::stream_type == streams::Length) {
    stream.advance(bytes);
  } else {
    std::uint8_t* const there = stream.advance(bytes);
    if (bytes == 0) return;
    if constexpr (kReads<Stream>) {
      std::memcpy(list.data(), there, bytes);
    } else {
      std::memcpy(there, list.data(), bytes);
    }
  }
}

template <class Stream, class List, class Each>
void list(Stream& stream, List& values, Each&& each) {
  size(stream, values);
  for (auto& value : values) each(value);
}

template <class Stream, class T>
void point(Stream& stream, T& value) {
  stream.next(value.x);
  stream.next(value.y);
}

template <class Stream, class T>
void pose(Stream& stream, T& value) {
  point(stream, value);
  stream.next(value.heading);
}

template <class Stream, class T>
void odometry(Stream& stream, T& value) {
  time(stream, value.stamp);
  pose(stream, value.pose);
  stream.next(value.velocity.linear);
  stream.next(value.velocity.angular);
}

template <class Stream, class T>
void scan(Stream& stream, T& value) {
  time(stream, value.stamp);
  stream.next(value.field);
  stream.next(value.max_range);
  numbers(stream, value.ranges);
}

template <class Stream, class T>
void clean_scan(Stream& stream, T& value) {
  scan(stream, value);
  odometry(stream, value.odometry);
  list(stream, value.points, [&stream](auto& one) { point(stream, one); });
}

template <class Stream, class T>
void frame(Stream& stream, T& value) {
  number<std::int32_t>(stream, value.left);
  number<std::int32_t>(stream, value.bottom);
  number<std::int32_t>(stream, value.width);
  number<std::int32_t>(stream, value.height);
}

template <class Stream, class T>
void anchor(Stream& stream, T& value) {
  number<std::uint32_t>(stream, value.keyframes);
  pose(stream, value.newest);
}

template <class Stream, class T>
void moving(Stream& stream, T& value) {
  point(stream, value.centre);
  stream.next(value.radius);
  point(stream, value.velocity);
  point(stream, value.course);
  stream.next(value.pace);
  stream.next(value.ahead);
  stream.next(value.behind);
  stream.next(value.unseen);
}

template <class Stream, class T>
void local_map(Stream& stream, T& value) {
  time(stream, value.stamp);
  odometry(stream, value.odometry);
  frame(stream, value.frame);
  numbers(stream, value.clearance);
  numbers(stream, value.static_clearance);
  list(stream, value.moving, [&stream](auto& one) { moving(stream, one); });
}

// What is shared and may be null: by whether it is there.
template <class Stream, class T, class Each>
void shared(Stream& stream, std::shared_ptr<const T>& value, Each&& each) {
  std::uint8_t is_there = 0;
  stream.next(is_there);
  if (is_there == 0) return value.reset();
  auto read = std::make_shared<T>();
  each(*read);
  value = std::move(read);
}
template <class Stream, class T, class Each>
void shared(Stream& stream, const std::shared_ptr<const T>& value, Each&& each) {
  const std::uint8_t is_there = value ? 1 : 0;
  stream.next(is_there);
  if (value) each(*value);
}

// Keyframes with what `each` says of one.
template <class Stream, class T, class Each>
void localization(Stream& stream, T& value, Each&& each) {
  time(stream, value.stamp);
  pose(stream, value.correction);
  number<std::uint64_t>(stream, value.loops);
  if constexpr (kReads<Stream>) {
    auto keyframes = std::make_shared<std::vector<Keyframe>>();
    list(stream, *keyframes, each);
    value.keyframes = std::move(keyframes);
  } else {
    list(stream, *value.keyframes, each);
  }
}

}  // namespace fields

// --- What each type is called, and is made of ---
//
// What follows has_newest, has_map or has_scan is left out where that is 0, which no node publishes.

// A sum of 32 hexadecimal digits, as ROS's are.
class Sum {
 public:
  explicit Sum(std::string_view definition) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::uint64_t hash = 14695981039346656037ULL;
    for (std::size_t at = 0; at < kLength; ++at) {
      for (const char letter : definition) hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211ULL;
      text_[at] = kDigits[(hash >> 32U) % 16U];
    }
  }
  const char* text() const { return text_.data(); }

 private:
  static constexpr std::size_t kLength = 32;
  std::array<char, kLength + 1> text_{};
};

#define CATAN_POINT "float64 x\nfloat64 y\n"
#define CATAN_POSE CATAN_POINT "float64 heading\n"
#define CATAN_ODOMETRY "int64 stamp\nPose2 pose\nfloat64 linear\nfloat64 angular\n"
#define CATAN_SCAN "int64 stamp\nfloat64 field\nfloat64 max_range\nfloat32[] ranges\n"
#define CATAN_NESTED(name, fields)                                                                                \
  "================================================================================\nMSG: catan_navigation/" name \
  "\n" fields

template <class T>
struct Described;

template <>
struct Described<run::Reading> {
  static constexpr const char* kName = "catan_navigation/Reading";
  static constexpr const char* kDefinition = "Scan scan\nOdometry odometry\n" CATAN_NESTED("Scan", CATAN_SCAN)
      CATAN_NESTED("Odometry", CATAN_ODOMETRY) CATAN_NESTED("Pose2", CATAN_POSE);
};
template <>
struct Described<CleanScan> {
  static constexpr const char* kName = "catan_navigation/CleanScan";
  static constexpr const char* kDefinition = CATAN_SCAN "Odometry odometry\nPoint2[] points\n" CATAN_NESTED(
      "Odometry", CATAN_ODOMETRY) CATAN_NESTED("Pose2", CATAN_POSE) CATAN_NESTED("Point2", CATAN_POINT);
};
template <>
struct Described<Surroundings> {
  static constexpr const char* kName = "catan_navigation/LocalMap";
  static constexpr const char* kDefinition =
      "Odometry odometry\nuint8 has_map\nint64 stamp\nOdometry of_scan\nint32 left\nint32 bottom\nint32 width\n"
      "int32 height\nfloat32[] clearance\nfloat32[] static_clearance\nMoving[] moving\n" CATAN_NESTED(
          "Odometry", CATAN_ODOMETRY) CATAN_NESTED("Pose2", CATAN_POSE) CATAN_NESTED("Point2", CATAN_POINT)
          CATAN_NESTED("Moving",
                       "Point2 centre\nfloat64 radius\nPoint2 velocity\nPoint2 course\nfloat64 pace\n"
                       "float64 ahead\nfloat64 behind\nfloat64 unseen\n");
};
template <>
struct Described<Fix> {
  static constexpr const char* kName = "catan_navigation/Localization";
  static constexpr const char* kDefinition =
      "Odometry odometry\nint64 stamp\nPose2 correction\nuint64 loops\nPose2[] keyframes\nuint8 has_newest\n"
      "CleanScan newest\n" CATAN_NESTED("CleanScan", CATAN_SCAN "Odometry odometry\nPoint2[] points\n")
          CATAN_NESTED("Odometry", CATAN_ODOMETRY) CATAN_NESTED("Pose2", CATAN_POSE)
              CATAN_NESTED("Point2", CATAN_POINT);
};
template <>
struct Described<KeyframesMessage> {
  static constexpr const char* kName = "catan_navigation/Keyframes";
  static constexpr const char* kDefinition =
      "int64 stamp\nPose2 correction\nuint64 loops\nKeyframe[] keyframes\n" CATAN_NESTED(
          "Keyframe", "Pose2 pose\nuint8 outdated\nuint8 has_scan\nScan scan\n") CATAN_NESTED("Scan", CATAN_SCAN)
          CATAN_NESTED("Pose2", CATAN_POSE);
};
template <>
struct Described<GlobalMap> {
  static constexpr const char* kName = "catan_navigation/GlobalMap";
  static constexpr const char* kDefinition =
      "int64 stamp\nint32 left\nint32 bottom\nint32 width\nint32 height\nuint32 anchor_keyframes\n"
      "Pose2 anchor_newest\nuint8[] cells\n" CATAN_NESTED("Pose2", CATAN_POSE);
};
template <>
struct Described<Path> {
  static constexpr const char* kName = "catan_navigation/Path";
  static constexpr const char* kDefinition =
      "int64 stamp\nuint8 outcome\nuint8 to_goal\nuint32 anchor_keyframes\nPose2 anchor_newest\n"
      "Point2[] points\n" CATAN_NESTED("Pose2", CATAN_POSE) CATAN_NESTED("Point2", CATAN_POINT);
};
template <>
struct Described<Command> {
  static constexpr const char* kName = "catan_navigation/Command";
  static constexpr const char* kDefinition =
      "int64 stamp\nuint8 stop\nuint8 look_around\nuint8 arrived\nPoint2 carrot\nPoint2[] beyond\n"
      "float64 distance_left\n" CATAN_NESTED("Point2", CATAN_POINT);
};

#undef CATAN_POINT
#undef CATAN_POSE
#undef CATAN_ODOMETRY
#undef CATAN_SCAN
#undef CATAN_NESTED

namespace fields {

template <class Stream, class T>
void all(Stream& stream, T& value) {
  using Value = std::remove_const_t<T>;
  if constexpr (std::is_same_v<Value, run::Reading>) {
    scan(stream, value.scan);
    odometry(stream, value.odometry);
  } else if constexpr (std::is_same_v<Value, CleanScan>) {
    clean_scan(stream, value);
  } else if constexpr (std::is_same_v<Value, Surroundings>) {
    odometry(stream, value.odometry);
    shared(stream, value.map, [&stream](auto& map) { local_map(stream, map); });
  } else if constexpr (std::is_same_v<Value, Fix>) {
    odometry(stream, value.odometry);
    localization(stream, value.localization, [&stream](auto& keyframe) { pose(stream, keyframe.pose); });
    shared(stream, value.localization.newest, [&stream](auto& newest) { clean_scan(stream, newest); });
  } else if constexpr (std::is_same_v<Value, KeyframesMessage>) {
    localization(stream, value.localization, [&stream](auto& keyframe) {
      pose(stream, keyframe.pose);
      number<std::uint8_t>(stream, keyframe.outdated);
      shared(stream, keyframe.scan, [&stream](auto& of_it) { scan(stream, of_it); });
    });
  } else if constexpr (std::is_same_v<Value, GlobalMap>) {
    time(stream, value.stamp);
    frame(stream, value.frame);
    anchor(stream, value.anchor);
    numbers(stream, value.cells);
  } else if constexpr (std::is_same_v<Value, Path>) {
    time(stream, value.stamp);
    number<std::uint8_t>(stream, value.outcome);
    number<std::uint8_t>(stream, value.to_goal);
    anchor(stream, value.anchor);
    list(stream, value.points, [&stream](auto& one) { point(stream, one); });
  } else {
    static_assert(std::is_same_v<Value, Command>);
    time(stream, value.stamp);
    number<std::uint8_t>(stream, value.stop);
    number<std::uint8_t>(stream, value.look_around);
    number<std::uint8_t>(stream, value.arrived);
    point(stream, value.carrot);
    list(stream, value.beyond, [&stream](auto& one) { point(stream, one); });
    stream.next(value.distance_left);
  }
}

template <class T>
concept Sent = requires {
  Described<T>::kName;
};

}  // namespace fields
}  // namespace ctn::navigation::ros1

// roscpp's, for all of them.
namespace ros {
namespace message_traits {

template <ctn::navigation::ros1::fields::Sent T>
struct IsMessage<T> : TrueType {};

template <ctn::navigation::ros1::fields::Sent T>
struct DataType<T> {
  static const char* value() { return ctn::navigation::ros1::Described<T>::kName; }
  static const char* value(const T& /*of*/) { return value(); }
};

template <ctn::navigation::ros1::fields::Sent T>
struct Definition<T> {
  static const char* value() { return ctn::navigation::ros1::Described<T>::kDefinition; }
  static const char* value(const T& /*of*/) { return value(); }
};

template <ctn::navigation::ros1::fields::Sent T>
struct MD5Sum<T> {
  static const char* value() {
    static const ctn::navigation::ros1::Sum kSum(Definition<T>::value());
    return kSum.text();
  }
  static const char* value(const T& /*of*/) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <ctn::navigation::ros1::fields::Sent T>
struct Serializer<T> {
  template <class Stream>
  static void write(Stream& stream, const T& value) {
    ctn::navigation::ros1::fields::all(stream, value);
  }
  template <class Stream>
  static void read(Stream& stream, T& value) {
    ctn::navigation::ros1::fields::all(stream, value);
  }
  // NOLINTNEXTLINE(readability-identifier-naming): as roscpp calls it
  static std::uint32_t serializedLength(const T& value) {
    LStream stream;
    ctn::navigation::ros1::fields::all(stream, value);
    return stream.getLength();
  }
};

}  // namespace serialization
}  // namespace ros
