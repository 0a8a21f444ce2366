// Drives the Verilated scorer. Orders come on standard input, answers go to standard output:
//
//   1 stall paths segments  w word*w  n point*n
//                     scores paths: the problem, 32 bits in each number, and the payloads of all
//                     points. With a stall s above 0, points and room come in about one cycle of s.
//       answers: paths * cycle of the launch, paths * (score, its cycle), segments * (cycle of the
//                record, two numbers of its bits)

#include "../../sim/harness/harness.hpp"

namespace {

using namespace harness;

class Scorer : Design {
public:
    void score(const Numbers& sizes, const Numbers& problem, const Numbers& points) {
        Pauses pauses{sizes[0]};
        Numbers launches, scores, chords;
        std::size_t taken = 0;
        const Number first = cycle_;
        for (std::size_t i = 0; i < problem.size(); ++i) top_.problem[i] = problem[i];
        bool offered = false;
        for (; scores.size() < 2 * sizes[1]; ++cycle_, clock()) {
            pauses.draw();
            // An offer stays until it is taken.
            offered = taken < points.size() && (offered || pauses.moves());
            top_.points___05Fvalid = offered;
            if (offered) top_.points___05Fpayload = points[taken];
            top_.room = pauses.moves(1);
            top_.phase = cycle_ & 1;
            top_.eval();
            if (offered && top_.points___05Fready) ++taken, offered = false;
            if (top_.launches) launches.push_back(cycle_);
            Numbers chord = read_port(top_.chord);
            if (chord[0] & 1) {
                chord.resize(2);
                chords.insert(chords.end(), {cycle_, chord[0], chord[1]});
            }
            if (top_.score & 1) scores.insert(scores.end(), {top_.score, cycle_});
            if (cycle_ - first > 400 * (points.size() + 100)) give_up();
        }
        if (launches.size() != sizes[1] || chords.size() != 3 * sizes[2]) std::exit(5);
        write_numbers(launches);
        write_numbers(scores);
        write_numbers(chords);
    }

private:
    Number cycle_ = 0;
};

}  // namespace

int main() {
    Scorer scorer;
    for (Number order; next_order(order);) {
        const Numbers sizes = read_numbers(3);
        const Numbers problem = read_numbers(read_number());
        scorer.score(sizes, problem, read_numbers(read_number()));
    }
    return 0;
}
