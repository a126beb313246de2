#include "vdbcloud/sim/air.h"

#include "vdbcloud/sim/effect.h"

namespace vdbcloud::sim {

template<typename T>
Air<T>::Air(const Parameters& p, const Column& c, const Thermodynamics& t)
    : parameters(p), column(c), thermo(t), lattice(p.lattice), rho{c.rho_centre, c.rho_face}
{
    const Quantity names[] = {Quantity::U, Quantity::V, Quantity::W};
    const Place places[] = {Place::FaceX, Place::FaceY, Place::FaceZ};
    for (const size_t axis : {0, 1, 2}) {
        wind[axis].quantity = names[axis], wind[axis].place = places[axis];
        if (axis < 2 && lattice.flat(int(axis))) continue;
        for (int i = 0; i < (p.momentum ? state_arrays(p) : 1); ++i) wind[axis].a[size_t(i)] = Field<T>(lattice);
    }
    if (p.buoyancy || p.moisture) allocate(theta, Quantity::Theta);
    if (!p.colliders.empty()) bodies = Openness<T>(p);
    fastest_rate = sim::fastest_rate(p);
    for (const Effect& effect : effects())
        if (effect.on(p)) effect.terms.add(*this);
    for (Variable<T>* v : scalars())
        if (v->has_sources() || open()) v->row_source.assign(size_t(lattice.n[1]) * size_t(lattice.n[2]), 0.0);
}

template<typename T>
void Air<T>::allocate(Variable<T>& v, Quantity q)
{
    v.quantity = q, v.place = Place::Centre;
    for (int i = 0; i < state_arrays(parameters); ++i) v.a[size_t(i)] = Field<T>(lattice);
}

template<typename T>
std::vector<double> Air<T>::environment(Quantity q) const
{
    std::vector<double> values;
    for (size_t k = 0; k < column.level.size(); ++k)
        values.push_back(q == Quantity::U       ? column.u[k]
                         : q == Quantity::V     ? column.v[k]
                         : q == Quantity::Theta ? column.level[k].theta_env
                         : q == Quantity::Water ? column.level[k].q_env
                                                : 0);
    return values;
}

template<typename T>
Relaxation& Air<T>::relax(Variable<T>& v)
{
    v.relaxation.environment = environment(v.quantity);
    return v.relaxation;
}

template<typename T>
Variable<T>& Air<T>::of(Quantity q)
{
    switch (q) {
    case Quantity::U: return wind[0];
    case Quantity::V: return wind[1];
    case Quantity::W: return wind[2];
    case Quantity::Theta: return theta;
    case Quantity::Water: return water;
    case Quantity::Rain: return rain;
    case Quantity::Fuel: return fuel;
    default: return dye;
    }
}

template<typename T>
std::vector<Variable<T>*> Air<T>::scalars()
{
    std::vector<Variable<T>*> list;
    for (Variable<T>* v : {&theta, &water, &rain, &dye, &fuel})
        if (*v) list.push_back(v);
    return list;
}

template<typename T>
std::vector<Variable<T>*> Air<T>::velocities()
{
    std::vector<Variable<T>*> list;
    for (Variable<T>& v : wind)
        if (v) list.push_back(&v);
    return list;
}

template<typename T>
double Air<T>::reference(Quantity q) const
{
    switch (q) {
    case Quantity::U: return parameters.frame[0];
    case Quantity::V: return parameters.frame[1];
    case Quantity::Theta: return column.reference.theta;
    case Quantity::Water: return column.reference.water;
    default: return 0;
    }
}

template<typename T>
size_t Air<T>::bytes() const
{
    size_t sum = 0;
    for (const Field<T>& f : own_) sum += f.bytes();
    for (const Variable<T>* v : {&wind[0], &wind[1], &wind[2], &theta, &water, &rain, &dye, &fuel})
        for (const Field<T>& f : v->a) sum += f.bytes();
    return sum;
}

template struct Air<float>;
template struct Air<double>;

}  // namespace vdbcloud::sim
