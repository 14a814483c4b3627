#include "ros1/thrown.h"

#include <cstdint>
#include <exception>
#include <utility>

#include <boost/make_shared.hpp>

namespace catan_ros {
namespace {

class Thrown final : public ros::CallbackInterface {
 public:
  explicit Thrown(std::exception_ptr exception) : exception_(std::move(exception)) {}
  CallResult call() override { std::rethrow_exception(exception_); }

 private:
  std::exception_ptr exception_;
};

}  // namespace

// Under an id of its own: who removes a callback has not seen yet what it threw.
void hand_on_exception(ros::CallbackQueueInterface& queue) {
  const auto thrown = boost::make_shared<Thrown>(std::current_exception());
  queue.addCallback(thrown, reinterpret_cast<std::uint64_t>(thrown.get()));
}

}  // namespace catan_ros
