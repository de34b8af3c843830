/**
 * touchref for C++11 and later: touchref.h with objects that free themselves, and refusals as exceptions.
 */
#ifndef TOUCHREF_HPP
#define TOUCHREF_HPP

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "touchref.h"

namespace touchref {

/** Why there is no result: what() is the message, json() all that is known. */
class error : public std::runtime_error {
public:
    /** Takes the error of a call over. */
    explicit error(touchref_error *failed)
        : std::runtime_error(touchref_error_message(failed)), failed_(failed, touchref_error_free) {}

    /** TOUCHREF_REFUSED: sound input without a frame to trust; TOUCHREF_WRONG_INPUT; TOUCHREF_INTERNAL. */
    touchref_status status() const { return touchref_error_status(failed_.get()); }
    /** As "ambiguous". */
    std::string code() const { return touchref_error_code(failed_.get()); }
    /** What to do about it. */
    std::string help() const { return touchref_error_help(failed_.get()); }
    /** touchref.error/1 */
    std::string json() const { return touchref_error_json(failed_.get()); }

private:
    /* Shared: an exception is copied when it is thrown. */
    std::shared_ptr<touchref_error> failed_;
};

namespace detail {

template <typename T, void (*Free)(T *)> struct freed {
    void operator()(T *object) const { Free(object); }
};

/** What a call hands out, or its error thrown. */
template <typename T, typename Call> T *result(Call call) {
    T *object = nullptr;
    touchref_error *failed = nullptr;
    if (call(&object, &failed) != TOUCHREF_OK) {
        throw error(failed);
    }
    return object;
}

} // namespace detail

/** A touch of which no more is known than where it is. The name must outlive it. */
inline touchref_touch touch(const char *surface, double x, double y, double z) {
    touchref_touch made = touchref_touch();
    made.surface = surface;
    made.at[0] = x;
    made.at[1] = y;
    made.at[2] = z;
    return made;
}

/** A frame that was found, with how far it can be trusted. The numbers that it has not told here are those of get(). */
class solution {
public:
    /** Takes a solution over. */
    explicit solution(touchref_solution *found) : found_(found) {}

    touchref_frame frame() const {
        touchref_frame frame;
        touchref_solution_frame(get(), &frame);
        return frame;
    }
    /** Whether the covariance is known, and if so, writes it. */
    bool covariance(touchref_covariance &covariance) const {
        return touchref_solution_covariance(get(), &covariance) != 0;
    }
    std::vector<touchref_root> roots() const {
        std::vector<touchref_root> all(touchref_solution_root_count(get()));
        for (std::size_t i = 0; i < all.size(); i++) {
            touchref_solution_root(get(), i, &all[i]);
        }
        return all;
    }
    std::vector<std::string> warnings() const {
        std::vector<std::string> all;
        while (const char *message = touchref_solution_warning_message(get(), all.size())) {
            all.push_back(message);
        }
        return all;
    }
    /** The frame in the words of a machine, as "kuka". */
    std::string tell(const std::string &dialect) const {
        std::unique_ptr<touchref_literal, detail::freed<touchref_literal, touchref_literal_free>> literal(
            detail::result<touchref_literal>([&](touchref_literal **literal, touchref_error **failed) {
                return touchref_solution_tell(get(), dialect.c_str(), literal, failed);
            }));
        return touchref_literal_text(literal.get());
    }
    /** touchref.solution/1 */
    std::string json() const { return touchref_solution_json(get()); }
    const touchref_solution *get() const { return found_.get(); }

private:
    std::unique_ptr<touchref_solution, detail::freed<touchref_solution, touchref_solution_free>> found_;
};

/** A kind of fixture with its parameters, as JSON or TOML. */
class fixture {
public:
    fixture(const std::string &kind, const std::string &parameters, const std::string &units)
        : made_(detail::result<touchref_fixture>([&](touchref_fixture **fixture, touchref_error **failed) {
              return touchref_fixture_new(kind.c_str(), parameters.c_str(), units.c_str(), fixture, failed);
          })) {}

    solution locate(const std::vector<touchref_touch> &touches, const touchref_probe &probe,
                    const touchref_options &options = touchref_options()) const {
        return solution(detail::result<touchref_solution>([&](touchref_solution **found, touchref_error **failed) {
            return touchref_locate(get(), touches.data(), touches.size(), &probe, &options, found, failed);
        }));
    }
    const touchref_fixture *get() const { return made_.get(); }

private:
    std::unique_ptr<touchref_fixture, detail::freed<touchref_fixture, touchref_fixture_free>> made_;
};

/** Locates from the text of a measurement file; tables and logs that it names are read from `folder`. */
inline solution locate(const std::string &measurement, const std::string &folder = std::string(),
                       const touchref_options &options = touchref_options()) {
    return solution(detail::result<touchref_solution>([&](touchref_solution **found, touchref_error **failed) {
        return touchref_locate_measurement(measurement.c_str(), folder.c_str(), &options, found, failed);
    }));
}

} // namespace touchref

#endif
