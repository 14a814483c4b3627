#include "ros1/thrown.h"

#include <cstdint>
#include <exception>
#include <utility>

#include <boost/make_shared.hpp>

#include "common/bound_callback.h"
#include "common/thrown.h"

namespace catan_ros {
namespace {

class Thrown final : public ros::CallbackInterface {
 public:
  void set(const std::exception_ptr& exception) { exception_ = exception; }
  CallResult call() override { std::rethrow_exception(exception_); }

 private:
  std::exception_ptr exception_;
};

// Under an id of its own: who removes the callback has not seen yet what it threw.
void hand_on(ros::CallbackQueueInterface& queue, const std::exception_ptr& exception) {
  if (BoundCallback::current() == nullptr) std::rethrow_exception(exception);
  const auto thrown = boost::make_shared<Thrown>();
  thrown->set(exception);
  queue.addCallback(thrown, reinterpret_cast<std::uint64_t>(thrown.get()));
}

Outcome to_outcome(ros::CallbackInterface::CallResult result) {
  switch (result) {
    case ros::CallbackInterface::Success:
      return Outcome::kCalled;
    case ros::CallbackInterface::TryAgain:
      return Outcome::kAgain;
    case ros::CallbackInterface::Invalid:
      break;
  }
  return Outcome::kNothing;
}

}  // namespace

std::function<Outcome()> handing_on_exceptions(ros::CallbackInterfacePtr callback, ros::CallbackQueueInterface& queue) {
  return [callback = std::move(callback), &queue] {
    return call_handing_on([&] { return to_outcome(callback->call()); }, Outcome::kCalled,
                           [&](const std::exception_ptr& exception) { hand_on(queue, exception); });
  };
}

std::function<bool()> handing_on_exceptions(std::function<bool()> call, ros::CallbackQueueInterface& queue) {
  return [call = std::move(call), &queue] {
    return call_handing_on(call, true, [&](const std::exception_ptr& exception) { hand_on(queue, exception); });
  };
}

}  // namespace catan_ros
