//! Raw bindings to Embree.
#![no_std]
