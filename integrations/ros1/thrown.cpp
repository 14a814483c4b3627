#include "ros1/thrown.h"

#include <cstdint>
#include <exception>
#include <utility>

#include <boost/make_shared.hpp>
#include <boost/ref.hpp>

#include "common/bound_callback.h"

namespace catan_ros {
namespace {

// To be made by a handler of the exception.
class Thrown final : public ros::CallbackInterface {
 public:
  CallResult call() override { std::rethrow_exception(exception_); }

 private:
  const std::exception_ptr exception_ = std::current_exception();
};

// By a handler of the exception. Under an id of its own: who removes the callback has not seen yet what it threw.
void hand_on(ros::CallbackQueueInterface& queue) {
  const auto thrown = boost::make_shared<Thrown>();
  queue.addCallback(thrown, reinterpret_cast<std::uint64_t>(thrown.get()));
}

class HandingOn final : public ros::CallbackInterface {
 public:
  HandingOn(ros::CallbackInterfacePtr callback, ros::CallbackQueueInterface& queue)
      : callback_(std::move(callback)), queue_(queue) {}

  CallResult call() override {
    try {
      return callback_->call();
    } catch (...) {
      if (BoundCallback::current() == nullptr) throw;
      hand_on(queue_);
      return Success;
    }
  }
  bool ready() override { return callback_->ready(); }

 private:
  const ros::CallbackInterfacePtr callback_;
  ros::CallbackQueueInterface& queue_;
};

}  // namespace

ros::CallbackInterfacePtr handing_on_exceptions(const ros::CallbackInterfacePtr& callback,
                                                ros::CallbackQueueInterface& queue) {
  return boost::make_shared<HandingOn>(callback, boost::ref(queue));
}

std::function<bool()> handing_on_exceptions(std::function<bool()> call, ros::CallbackQueueInterface& queue) {
  return [call = std::move(call), &queue] {
    try {
      return call();
    } catch (...) {
      if (BoundCallback::current() == nullptr) throw;
      hand_on(queue);
      return true;
    }
  };
}

}  // namespace catan_ros
