static const uint32_t STATES[] = {@STATES@};
static const uint32_t RATES[] = {@RATES@};
static const double NOMINALS[] = {@NOMINALS@};
static const uint32_t INDICATORS[] = {@INDICATORS@};
static const uint32_t UNKNOWNS[] = {@UNKNOWNS@};

static const struct Continuous CONTINUOUS = {
    .states = STATES,
    .rates = RATES,
    .nominals = NOMINALS,
    .state_count = sizeof STATES / sizeof *STATES,
    .indicators = INDICATORS,
    .indicator_count = sizeof INDICATORS / sizeof *INDICATORS,
    .unknowns = UNKNOWNS,
    .unknown_count = sizeof UNKNOWNS / sizeof *UNKNOWNS,
    .derive = derive_block,
    .differentiate = differentiate_block,
    .settle = settle_block,
    .measure = measure_block,
};

